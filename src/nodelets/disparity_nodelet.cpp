#include <image_transport/image_transport.h>

#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <sstream>
#include <string>

#include "nodelets/cloud_output.h"
#include "nodelets/disparity_processor.h"
#include "nodelets/disparity_views.h"
#include "nodelets/frame_nodelet.h"
#include "nodelets/mask_input.h"
#include "nodelets/odometry_input.h"
#include "nodelets/stereo_input.h"

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
class DisparityNodelet : public FrameNodelet<DisparityNodeletParams, StereoPair, DisparityProcessor,
                                             DisparityEstimator, DisparityParams> {
 public:
  DisparityNodelet()
      : FrameNodelet("Disparity", "disparity", &DisparityProcessorParams::disparity,
                     {"use_moving_mask"}) {}
  ~DisparityNodelet() override { shutDown(); }

 private:
  void connect(ros::NodeHandle& node) override {
    reportSimdTarget();
    odometry_ = std::make_unique<OdometryInput>(node, *health_, arrivals_);
    clouds_ = std::make_unique<CloudOutput>(node, outputs_, *health_, params_.points);
    masks_ = std::make_unique<MaskInput>(
        node, *health_, arrivals_,
        [this](const sensor_msgs::ImageConstPtr& mask) { clouds_->finish(mask); });
    input_ = std::make_unique<StereoInput>(
        node, *health_, params_.sync, [this](const StereoPair& pair) { loop_->push(pair); },
        [this](ros::Time stamp) {
          tf_->goBackTo(stamp);
          odometry_->goBackTo(stamp);
          columns_.goBackTo(stamp);
        });
    advertise(node);
  }

  void subscribeInputs() override {
    clouds_->forget();
    // Before the images, so that no motion is missed.
    odometry_->start();
    columns_subscription_.replace(
        subscribe<RowAlignment>(getNodeHandle(), *health_, "odometry/row_alignment", 5,
                                [this](const RowAlignmentConstPtr& columns) {
                                  requireRowAlignment(*columns);
                                  columns_.add(columns);
                                }));
    input_->start();
  }

  void unsubscribeInputs() override {
    if (input_) input_->stop();
    if (masks_) masks_->stop();
    columns_subscription_.shutdown();
    if (odometry_) odometry_->stop();
    columns_.clear();
  }

  // If the inputs of MovingObjects are the only outputs with subscribers, this nodelet must not
  // keep MovingObjects awake: so it uses the passive topic.
  void followDemand() override {
    const bool needed = wanted() && (usesMovingMask() || clouds_->areWanted());
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
    measured_disparity_ = for_detection_.advertise<DisparityImage>(node, "measured_disparity", 5);
    predicted_disparity_ = for_detection_.advertise<DisparityImage>(node, "predicted_disparity", 5);
    measured_variance_ = for_detection_.advertise<Image>(node, "measured_variance", 5);
    predicted_variance_ = for_detection_.advertise<Image>(node, "predicted_variance", 5);
    row_alignment_ = for_detection_.advertise<RowAlignment>(node, "row_alignment", 5);
  }

  bool usesMovingMask() const { return params_.processor.disparity.use_moving_mask; }

  std::string describeMissingInput() const override {
    return input_ ? input_->describeMissingInput() : "";
  }

  bool wanted() const override { return outputs_.wanted() || for_detection_.wanted(); }

  void process(const Job& job) override {
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
    report(messages);
    finish(job, times, "pairs", "left images", input_->unmatched());
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
    clouds_->prepare(messages.disparity, pair, *masks_);
  }

  void reportSimdTarget() {
    const std::string slow = processor_->slowTargetWarning();
    if (slow.empty())
      health_->solved("SIMD target");
    else
      health_->problem("SIMD target", Health::Severity::kDegraded, slow);
    health_->figure("SIMD target", processor_->simdTarget());
  }

  void report(const DisparityMessages& messages) {
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
  }

  Outputs for_detection_{[this] { updateDemand(); }};  // inputs of MovingObjects
  ros::Publisher disparity_, measured_disparity_, predicted_disparity_, disparity_variance_,
      measured_variance_, predicted_variance_, row_alignment_, search_range_, disparity_image_,
      standard_deviation_, depth_image_, depth_info_;
  image_transport::Publisher colour_image_;
  std::unique_ptr<OdometryInput> odometry_;
  MessageHistory<RowAlignment> columns_;
  std::unique_ptr<CloudOutput> clouds_;
  std::unique_ptr<MaskInput> masks_;
  Subscription columns_subscription_;
  std::unique_ptr<StereoInput> input_;
};

}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::DisparityNodelet, nodelet::Nodelet)
