#include <image_transport/image_transport.h>
#include <sensor_msgs/PointCloud2.h>

#include <memory>
#include <mutex>
#include <optional>
#include <pluginlib/class_list_macros.hpp>

#include "nodelets/disparity_processor.h"
#include "nodelets/frame_nodelet.h"
#include "nodelets/mask_input.h"
#include "nodelets/odometry_input.h"
#include "nodelets/views.h"

namespace predictive_stereo {
namespace {

/// Disparity's topics of views.h, made while they have subscribers. The clouds, points2 and
/// points2_static, need the mask of moving objects of their frame, which arrives a little later, or
/// not at all.
///
/// Thread-safe.
class ViewOutput {
 public:
  ViewOutput(ros::NodeHandle& node, Outputs& outputs, Health& health, const PointsParams& params)
      : health_(health),
        params_(params),
        disparity_(outputs.advertise<sensor_msgs::Image>(node, "disparity/image", 5)),
        standard_deviation_(
            outputs.advertise<sensor_msgs::Image>(node, "disparity/standard_deviation", 5)),
        depth_(outputs.advertise<sensor_msgs::Image>(node, "depth/image_rect", 5)),
        depth_info_(outputs.advertise<sensor_msgs::CameraInfo>(node, "depth/camera_info", 5)),
        cloud_(outputs.advertise<sensor_msgs::PointCloud2>(node, "points2", 5)),
        static_cloud_(outputs.advertise<sensor_msgs::PointCloud2>(node, "points2_static", 5)),
        colour_(outputs.advertiseImage(node, "disparity/color", 5)) {}

  bool needsMask() const {
    return cloud_.getNumSubscribers() > 0 || static_cloud_.getNumSubscribers() > 0;
  }
  /// Publishes all but the clouds, which may wait until their mask or the next frame arrives.
  void publish(const DisparityMessages& messages, const StereoPair& pair, const MaskInput& masks) {
    const stereo_msgs::DisparityImageConstPtr disparity = messages.disparity;
    if (disparity_.getNumSubscribers() > 0) disparity_.publish(innerImage(disparity));
    if (colour_.getNumSubscribers() > 0) colour_.publish(colourImage(*disparity));
    if (standard_deviation_.getNumSubscribers() > 0)
      standard_deviation_.publish(standardDeviationImage(*messages.disparity_variance));
    if (depth_.getNumSubscribers() > 0) depth_.publish(depthImage(*disparity));
    if (depth_info_.getNumSubscribers() > 0) depth_info_.publish(depthCameraInfo(pair));

    const std::lock_guard<std::mutex> lock(mutex_);
    if (pending_) publishClouds(nullptr);
    if (!needsMask()) return;
    pending_ = Pending{disparity, pair};
    const sensor_msgs::ImageConstPtr mask = masks.at(disparity->header.stamp);
    if (mask || !masks.isPublished()) publishClouds(mask.get());
  }

  /// Publishes the clouds that wait for this mask.
  void finishClouds(const sensor_msgs::ImageConstPtr& mask) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (pending_ && pending_->disparity->header.stamp == mask->header.stamp)
      publishClouds(mask.get());
  }

  void forget() {
    const std::lock_guard<std::mutex> lock(mutex_);
    pending_.reset();
    missing_masks_ = 0;
  }

 private:
  struct Pending {
    stereo_msgs::DisparityImageConstPtr disparity;
    StereoPair pair;
  };
  void publishClouds(const sensor_msgs::Image* mask) {
    health_.guard("points2", [&] {
      const StereoRig rig = stereoRig(pending_->pair);
      const auto cloud = [&](MovingPoints moving) {
        return pointCloud(*pending_->disparity, rig, *pending_->pair.left, mask, params_, moving);
      };
      if (cloud_.getNumSubscribers() > 0) cloud_.publish(cloud(MovingPoints::kTinted));
      if (static_cloud_.getNumSubscribers() == 0) return;
      // No cloud is better for a planner than a cloud with possible moving objects.
      if (mask) static_cloud_.publish(cloud(MovingPoints::kLeftOut));
      reportMissingMask(!mask);
    });
    pending_.reset();
  }

  void reportMissingMask(bool missing) {
    constexpr int kTellMissingMasks = 10;
    missing_masks_ = missing ? missing_masks_ + 1 : 0;
    if (!missing) health_.solved("points2_static");
    if (missing_masks_ == kTellMissingMasks)
      health_.problem("points2_static",
                      "points2_static is not published, as the mask of moving objects is missing: "
                      "run the MovingObjects nodelet (launch argument moving_objects:=true)");
  }

  Health& health_;
  const PointsParams params_;
  ros::Publisher disparity_, standard_deviation_, depth_, depth_info_, cloud_, static_cloud_;
  image_transport::Publisher colour_;
  std::mutex mutex_;
  std::optional<Pending> pending_;
  int missing_masks_ = 0;  // consecutive clouds without a mask
};

}  // namespace

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
class DisparityNodelet
    : public FrameNodelet<DisparityNodeletParams, StereoInput, DisparityProcessor,
                          DisparityLoop::Stages, DisparityParams> {
 public:
  DisparityNodelet()
      : FrameNodelet("Disparity", "disparity", &DisparityNodeletParams::disparity,
                     {"use_moving_mask"}) {}
  ~DisparityNodelet() override { shutDown(); }

 private:
  void connect(ros::NodeHandle& node) override {
    reportSimdTarget();
    odometry_ =
        std::make_unique<OdometryInput>(node, *health_, arrivals_, *tf_, params_.odom_frame,
                                        params_.transform_timeout, "odometry/row_alignment");
    views_ = std::make_unique<ViewOutput>(node, outputs_, *health_, params_.points);
    masks_ = std::make_unique<MaskInput>(
        node, *health_, arrivals_,
        [this](const sensor_msgs::ImageConstPtr& mask) { views_->finishClouds(mask); });
    makeInput(node, params_.sync);
    advertise(node);
  }

  void subscribeInputs() override {
    views_->forget();
    odometry_->start();
  }

  void unsubscribeInputs() override {
    if (masks_) masks_->stop();
    if (odometry_) odometry_->stop();
  }

  void goBackTo(ros::Time stamp) override { odometry_->goBackTo(stamp); }

  // If the inputs of MovingObjects are the only outputs with subscribers, this nodelet must not
  // keep MovingObjects awake: so it uses the passive topic.
  void followDemand() override {
    const bool needed = wanted() && (params_.disparity.use_moving_mask || views_->needsMask());
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
    measured_disparity_ = for_detection_.advertise<DisparityImage>(node, "measured_disparity", 5);
    predicted_disparity_ = for_detection_.advertise<DisparityImage>(node, "predicted_disparity", 5);
    measured_variance_ = for_detection_.advertise<Image>(node, "measured_variance", 5);
    predicted_variance_ = for_detection_.advertise<Image>(node, "predicted_variance", 5);
    row_alignment_ = for_detection_.advertise<RowAlignment>(node, "row_alignment", 5);
  }

  bool wanted() const override { return outputs_.wanted() || for_detection_.wanted(); }

  void process(const Job& job) override {
    const SequenceGuard::Result sequence = processor_->begin(job.frame);
    tell(sequence);
    if (sequence.isIgnored()) return;
    if (sequence.verdict != SequenceGuard::Verdict::kContinues) masks_->forget();

    StageTimes waiting;
    sensor_msgs::ImageConstPtr mask;  // owns the memory of the view below
    DisparityProcessor::Sources sources;
    sources.motion = [&](const Past& past) {
      std::optional<CameraMotion> motion;
      Stopwatch watch;
      if (past.stamp()) motion = odometry_->motion(rosTime(*past.stamp()), job.frame.left->header);
      watch.lap("waiting for motion", waiting);
      return motion;
    };
    sources.moved = [&](Stamp before) {
      Stopwatch watch;
      mask = masks_->waitForMask(rosTime(before), params_.transform_timeout);
      watch.lap("waiting for moving objects", waiting);
      return masks_->usable(mask, *job.frame.left);
    };
    sources.measured = [&](const DisparityMessages& messages) { publishForDetection(messages); };
    if (const RowAlignmentConstPtr told = odometry_->columns().before(job.frame.left->header.stamp))
      sources.column_offset = columnOffset(*told);
    const DisparityMessages messages = processor_->process(sources);
    StageTimes times = processor_->times();
    times.insert(times.end(), waiting.begin(), waiting.end());
    publish(messages, job.frame);
    report(messages);
    finish(job, times, "pairs", "left images");
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
    views_->publish(messages, pair, *masks_);
  }

  void reportSimdTarget() {
    health_->problem("SIMD target", processor_->slowTargetWarning());
    health_->figure("SIMD target", processor_->simdTarget());
  }

  void report(const DisparityMessages& messages) {
    constexpr double kMostContradicted = 0.3;
    if (messages.contradicted_fraction > kMostContradicted)
      health_->problem("prediction",
                       "many measured disparities contradict the prediction by the motion of "
                       "odom_frame '" +
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
  }

  Outputs for_detection_{[this] { updateDemand(); }};  // inputs of MovingObjects
  ros::Publisher disparity_, measured_disparity_, predicted_disparity_, disparity_variance_,
      measured_variance_, predicted_variance_, row_alignment_, search_range_;
  std::unique_ptr<OdometryInput> odometry_;
  std::unique_ptr<ViewOutput> views_;
  std::unique_ptr<MaskInput> masks_;
};

}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::DisparityNodelet, nodelet::Nodelet)
