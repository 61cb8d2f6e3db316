#include <image_transport/image_transport.h>
#include <nav_msgs/Odometry.h>
#include <nodelet/nodelet.h>

#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>

#include "nodelets/disparity_processor.h"
#include "nodelets/disparity_views.h"
#include "nodelets/frame_loop.h"
#include "nodelets/health.h"
#include "nodelets/mask_input.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/odometry_input.h"
#include "nodelets/outputs.h"
#include "nodelets/ros_params.h"
#include "nodelets/stereo_input.h"
#include "nodelets/tf_input.h"
#include "nodelets/thread_limit.h"

namespace predictive_stereo {

/// Dense disparity with variance, predicted from the past by the camera's motion.
///
/// Subscribes: left/image_rect, left/camera_info, right/image_rect, right/camera_info; /tf (motion
///   relative to odom_frame); odometry (its covariance); odometry/row_alignment;
///   moving_objects/mask if ~use_moving_mask is set or points2 has subscribers
///   (moving_objects/passive_mask if only the inputs of MovingObjects have subscribers).
/// Publishes: disparity, measured_disparity, predicted_disparity, disparity_variance,
///   measured_variance, predicted_variance, row_alignment, and on demand disparity/image,
///   disparity/color, disparity/standard_deviation, search_range, depth/image_rect,
///   depth/camera_info, points2, points2_static; /diagnostics. Without subscribers of its outputs
///   it subscribes only to /tf.
/// Services: ~reset, and those of dynamic_reconfigure.
/// Parameters: DisparityNodeletParams.
class DisparityNodelet : public nodelet::Nodelet {
 public:
  ~DisparityNodelet() override {
    arrivals_.stop();
    if (health_) health_->stop();
    demand_.stop();
    sleep();
    if (loop_) loop_->stop();
  }

 private:
  using Loop = FrameLoop<StereoPair, DisparityProcessor, DisparityParams>;
  // Point clouds that wait for the mask of their frame.
  struct PendingClouds {
    stereo_msgs::DisparityImageConstPtr disparity;
    StereoPair pair;
  };

  void onInit() override {
    health_ = std::make_unique<Health>(getNodeHandle(), getPrivateNodeHandle(), getName(),
                                       "Disparity", [this] { return describeMissingInput(); });
    health_->guard(
        "parameters", [this] { start(getNodeHandle(), getPrivateNodeHandle()); },
        Health::Severity::kBroken);
    health_->start();
  }

  static constexpr int kTellMissingMasks = 10;

  void start(ros::NodeHandle& node, ros::NodeHandle& private_node) {
    ParamTable table(params_, rosParamPrefix(private_node));
    for (const std::string& warning : setFromRosParams(private_node, table))
      health_->event(warning);
    limitThreads(params_.threads);
    processor_ = std::make_unique<DisparityProcessor>(params_.processor);
    reportSimdTarget();
    tf_ = std::make_unique<TfInput>(node, *health_, arrivals_);
    odometry_ = std::make_unique<OdometryInput>(node, *health_, arrivals_);
    loop_ = std::make_unique<Loop>(
        private_node, *health_, *processor_, params_.processor.disparity,
        Loop::Hooks{[this](const Loop::Job& job) { process(job); },
                    [](const DisparityParams& params) { DisparityEstimator{params}; },
                    "disparity",
                    {"use_moving_mask"}});
    masks_ = std::make_unique<MaskInput>(
        node, *health_, arrivals_,
        [this](const sensor_msgs::ImageConstPtr& mask) { finishClouds(mask); });
    input_ = std::make_unique<StereoInput>(
        node, *health_, params_.sync, [this](const StereoPair& pair) { loop_->push(pair); },
        [this](ros::Time stamp) {
          tf_->goBackTo(stamp);
          odometry_->goBackTo(stamp);
          columns_.goBackTo(stamp);
        });
    advertise(node);
    demand_.start();
  }

  void wake() {
    {
      const std::lock_guard<std::mutex> lock(cloud_mutex_);
      pending_clouds_.reset();
      missing_masks_ = 0;
    }
    // Before the images, so that no motion is missed.
    ros::NodeHandle& node = getNodeHandle();
    odometry_->start();
    columns_subscription_.replace(subscribe<RowAlignment>(
        node, *health_, "odometry/row_alignment", 5, [this](const RowAlignmentConstPtr& columns) {
          requireRowAlignment(*columns);
          columns_.add(columns);
        }));
    loop_->setAwake(true);
    input_->start();
  }

  void guardSubscriptions(const std::function<void()>& work) {
    health_->guard("subscriptions", work, Health::Severity::kBroken);
  }

  void sleep() {
    if (input_) input_->stop();
    if (loop_) loop_->setAwake(false);
    if (masks_) masks_->stop();
    columns_subscription_.shutdown();
    if (odometry_) odometry_->stop();
    columns_.clear();
  }

  // If the inputs of MovingObjects are the only outputs with subscribers, this nodelet must not
  // keep MovingObjects awake: so it uses the passive topic.
  void followMasks() {
    const bool needed = wanted() && (usesMovingMask() || cloudsAreWanted());
    masks_->listenTo(!needed             ? ""
                     : outputs_.wanted() ? MaskInput::kTopic
                                         : MaskInput::kPassiveTopic);
  }

  void advertise(ros::NodeHandle& node) {
    using sensor_msgs::Image;
    using stereo_msgs::DisparityImage;
    disparity_ = outputs_.advertise<DisparityImage>(node, "disparity", 5);
    disparity_variance_ = outputs_.advertise<Image>(node, "disparity_variance", 5);
    search_range_ = outputs_.advertise<Image>(node, "search_range", 5);
    disparity_image_ = outputs_.advertise<Image>(node, "disparity/image", 5);
    standard_deviation_ = outputs_.advertise<Image>(node, "disparity/standard_deviation", 5);
    colour_image_ = outputs_.advertiseImage(node, "disparity/color", 5);
    depth_image_ = outputs_.advertise<Image>(node, "depth/image_rect", 5);
    depth_info_ = outputs_.advertise<sensor_msgs::CameraInfo>(node, "depth/camera_info", 5);
    cloud_ = outputs_.advertise<sensor_msgs::PointCloud2>(node, "points2", 5);
    static_cloud_ = outputs_.advertise<sensor_msgs::PointCloud2>(node, "points2_static", 5);
    measured_disparity_ = for_detection_.advertise<DisparityImage>(node, "measured_disparity", 5);
    predicted_disparity_ = for_detection_.advertise<DisparityImage>(node, "predicted_disparity", 5);
    measured_variance_ = for_detection_.advertise<Image>(node, "measured_variance", 5);
    predicted_variance_ = for_detection_.advertise<Image>(node, "predicted_variance", 5);
    row_alignment_ = for_detection_.advertise<RowAlignment>(node, "row_alignment", 5);
  }

  bool usesMovingMask() const { return params_.processor.disparity.use_moving_mask; }

  std::string describeMissingInput() const { return input_ ? input_->describeMissingInput() : ""; }

  bool wanted() const { return outputs_.wanted() || for_detection_.wanted(); }

  void process(const Loop::Job& job) {
    const SequenceGuard::Result sequence = processor_->begin(job.frame);
    if (sequence.verdict == SequenceGuard::Verdict::kDuplicate) return;
    if (sequence.startsAnew()) health_->event(sequence.reason);
    if (sequence.verdict != SequenceGuard::Verdict::kContinues) masks_->forget();

    StageTimes waiting;
    sensor_msgs::ImageConstPtr mask;  // owns the memory of the view below
    DisparityProcessor::Sources sources;
    sources.motion = [&](std::optional<ros::Time> past) {
      Stopwatch watch;
      const auto camera_motion = motion(past, job.frame.left->header);
      watch.lap("waiting for motion", waiting);
      return camera_motion;
    };
    sources.moved = [&](ros::Time before) {
      Stopwatch watch;
      mask = masks_->waitForMask(before, params_.transform_timeout);
      watch.lap("waiting for moving objects", waiting);
      return masks_->usable(mask, *job.frame.left);
    };
    sources.measured = [&](const DisparityMessages& messages) { publishForDetection(messages); };
    if (const RowAlignmentConstPtr told = columns_.before(job.frame.left->header.stamp))
      sources.column_offset = columnOffset(*told);
    const DisparityMessages messages = processor_->process(sources);
    StageTimes times = processor_->times();
    times.insert(times.end(), waiting.begin(), waiting.end());
    publish(messages, job.frame);
    report(job, messages, times);
  }

  std::optional<CameraMotion> motion(std::optional<ros::Time> previous,
                                     const std_msgs::Header& now) {
    if (!previous) return std::nullopt;
    MotionAnswer answer =
        odometry_->waitFor(params_.transform_timeout, [&](const OdometryHistory* odometry) {
          return cameraMotion(tf_->buffer, odometry, now.frame_id, *previous, now.stamp,
                              params_.odom_frame);
        });
    if (answer.motion)
      health_->solved("motion");
    else
      health_->problem("motion", Health::Severity::kDegraded,
                       describeMissingMotion(now.frame_id, answer));
    return answer.motion;
  }

  std::string describeMissingMotion(const std::string& camera, const MotionAnswer& answer) const {
    if (camera.empty()) return std::string(kNoFrame) + ": matched without prediction";
    if (answer.complete) return answer.reason + ": matched without prediction";
    // Not the text of tf, which contains stamps: a text that changes is logged every time.
    std::ostringstream text;
    text << "tf has no motion of '" << camera << "' relative to odom_frame '" << params_.odom_frame
         << "' at the image's stamp within transform_timeout = " << params_.transform_timeout
         << " s: matched without prediction. Run the EgoMotion nodelet with publish_tf, or set "
            "odom_frame to the fixed frame of your odometry";
    return text.str();
  }

  // The inputs of MovingObjects.
  void publishForDetection(const DisparityMessages& messages) {
    row_alignment_.publish(messages.row_alignment);  // first: MovingObjects does not wait for it
    measured_disparity_.publish(messages.measured_disparity);
    predicted_disparity_.publish(messages.predicted_disparity);
    measured_variance_.publish(messages.measured_variance);
    predicted_variance_.publish(messages.predicted_variance);
  }

  void publish(const DisparityMessages& messages, const StereoPair& pair) {
    disparity_.publish(messages.disparity);
    disparity_variance_.publish(messages.disparity_variance);
    search_range_.publish(messages.search_range);
    if (disparity_image_.getNumSubscribers() > 0)
      disparity_image_.publish(innerImage(messages.disparity));
    if (colour_image_.getNumSubscribers() > 0)
      colour_image_.publish(colourImage(*messages.disparity));
    if (standard_deviation_.getNumSubscribers() > 0)
      standard_deviation_.publish(standardDeviationImage(*messages.disparity_variance));
    if (depth_image_.getNumSubscribers() > 0) depth_image_.publish(depthImage(*messages.disparity));
    if (depth_info_.getNumSubscribers() > 0) depth_info_.publish(depthCameraInfo(pair));
    prepareClouds({messages.disparity, pair});
  }

  bool cloudsAreWanted() const {
    return cloud_.getNumSubscribers() > 0 || static_cloud_.getNumSubscribers() > 0;
  }

  // The clouds need the mask of moving objects, which arrives a little later, or not at all.
  void prepareClouds(const PendingClouds& clouds) {
    const std::lock_guard<std::mutex> lock(cloud_mutex_);
    if (pending_clouds_) publishClouds(nullptr);
    if (!cloudsAreWanted()) return;
    pending_clouds_ = clouds;
    const sensor_msgs::ImageConstPtr mask = masks_->at(clouds.disparity->header.stamp);
    if (mask || !masks_->isPublished()) publishClouds(mask.get());
  }

  void finishClouds(const sensor_msgs::ImageConstPtr& mask) {
    const std::lock_guard<std::mutex> lock(cloud_mutex_);
    if (pending_clouds_ && pending_clouds_->disparity->header.stamp == mask->header.stamp)
      publishClouds(mask.get());
  }

  void publishClouds(const sensor_msgs::Image* mask) {
    const PendingClouds& clouds = *pending_clouds_;
    try {
      const StereoRig rig = stereoRig(clouds.pair);
      const auto cloud = [&](MovingPoints moving) {
        return pointCloud(*clouds.disparity, rig, *clouds.pair.left, mask, params_.points, moving);
      };
      if (cloud_.getNumSubscribers() > 0) cloud_.publish(cloud(MovingPoints::kTinted));
      if (static_cloud_.getNumSubscribers() > 0) {
        // No cloud is better for a planner than a cloud with possible moving objects.
        if (mask) static_cloud_.publish(cloud(MovingPoints::kLeftOut));
        reportMissingMask(!mask);
      }
    } catch (const std::exception& e) {
      health_->problem("points2", Health::Severity::kDegraded, e.what());
    }
    pending_clouds_.reset();
  }

  void reportMissingMask(bool missing) {
    missing_masks_ = missing ? missing_masks_ + 1 : 0;
    if (!missing) health_->solved("points2_static");
    if (missing_masks_ == kTellMissingMasks)
      health_->problem("points2_static", Health::Severity::kDegraded,
                       "points2_static is not published, as the mask of moving objects is missing: "
                       "run the MovingObjects nodelet (launch argument moving_objects:=true)");
  }

  void reportSimdTarget() {
    const std::string slow = processor_->slowTargetWarning();
    if (slow.empty())
      health_->solved("SIMD target");
    else
      health_->problem("SIMD target", Health::Severity::kDegraded, slow);
    health_->figure("SIMD target", processor_->simdTarget());
  }

  void report(const Loop::Job& job, const DisparityMessages& messages, const StageTimes& times) {
    constexpr double kMostContradicted = 0.3;
    if (messages.contradicted_fraction > kMostContradicted)
      health_->problem(
          "prediction", Health::Severity::kDegraded,
          "many measured disparities contradict the prediction by the motion of odom_frame '" +
              params_.odom_frame +
              "': does this odometry jump? Use another one, or the EgoMotion nodelet");
    else
      health_->solved("prediction");
    health_->figure("prediction contradicted [%]", 100 * messages.contradicted_fraction, "%.1f");
    reportSimdTarget();
    health_->figure("predicted", messages.predicted ? "yes" : "no");
    health_->figure("mean search width [px]", messages.mean_search_width_px, "%.1f");
    health_->figure("disparity space searched [%]", 100 * messages.searched_fraction, "%.1f");
    health_->figure("largest row offset [px]", messages.row_alignment->largest_offset, "%.2f");
    health_->figure("row offset residual [px]", messages.row_alignment->residual, "%.2f");
    health_->figure("columns corrected by [px]", messages.row_alignment->column_correction, "%.2f");
    health_->figure("dropped pairs", static_cast<double>(loop_->dropped()), "%.0f");
    health_->figure("unmatched left images", static_cast<double>(input_->unmatched()), "%.0f");
    health_->frame(job.frame.left->header.stamp, job.ageMs(), times);
  }

  DisparityNodeletParams params_;
  Demand demand_{{[this] { return wanted(); }, [this] { wake(); }, [this] { sleep(); },
                  [this] { followMasks(); },
                  [this](const auto& work) { guardSubscriptions(work); }}};
  std::unique_ptr<Health> health_;
  Arrivals arrivals_;
  std::unique_ptr<TfInput> tf_;
  std::unique_ptr<OdometryInput> odometry_;
  MessageHistory<RowAlignment> columns_;
  std::unique_ptr<DisparityProcessor> processor_;

  Outputs outputs_{[this] { demand_.update(); }};
  Outputs for_detection_{[this] { demand_.update(); }};  // inputs of MovingObjects
  ros::Publisher disparity_, measured_disparity_, predicted_disparity_, disparity_variance_,
      measured_variance_, predicted_variance_, row_alignment_, search_range_, disparity_image_,
      standard_deviation_, depth_image_, depth_info_, cloud_, static_cloud_;
  image_transport::Publisher colour_image_;

  std::mutex cloud_mutex_;
  std::optional<PendingClouds> pending_clouds_;
  int missing_masks_ = 0;  // consecutive clouds without a mask
  std::unique_ptr<MaskInput> masks_;

  Subscription columns_subscription_;
  std::unique_ptr<Loop> loop_;
  std::unique_ptr<StereoInput> input_;
};

}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::DisparityNodelet, nodelet::Nodelet)
