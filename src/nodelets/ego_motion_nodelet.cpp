#include <cmath>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>

#include "nodelets/frame_nodelet.h"
#include "nodelets/message_input.h"
#include "nodelets/output_topics.h"
#include "nodelets/rotation_input.h"
#include "nodelets/tf_output.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {
namespace {

/// Odometry of a stereo camera. Topics, services and parameters: docs/nodes.md.
class EgoMotionNodelet : public FrameNodelet<EgoMotionNodeletParams, StereoInput,
                                             EgoMotionProcessor, EgoMotion, EgoMotionParams> {
 public:
  EgoMotionNodelet()
      : FrameNodelet("EgoMotion", "ego_motion", &EgoMotionNodeletParams::ego_motion, {}) {}
  ~EgoMotionNodelet() override { shutDown(); }

 private:
  TfInput::Listener tfListener() override {
    return [this](const geometry_msgs::TransformStamped& transform, const std::string& publisher,
                  bool is_static) { tf_output_.addTransform(transform, publisher, is_static); };
  }

  void connect(ros::NodeHandle& node) override {
    if (params_.publish_tf) tf_output_.start(node);
    masks_.emplace(node, *health_, arrivals_, kMasksKept);
    rotation_.emplace(node, *health_, arrivals_, *tf_, params_);
    makeInput(node, params_.sync);
    visitEgoMotionOutputs(*outputs_);
  }

  // It is unknown whether a node needs its transforms.
  bool mustNotSleep() const { return params_.publish_tf && !params_.lazy; }
  bool wanted() const override { return mustNotSleep() || outputs_->wanted(); }

  void subscribeInputs() override {
    // MovingObjects needs this nodelet. If each kept the other one awake, neither would ever sleep.
    if (params_.use_moving_mask)
      masks_->listenTo(mustNotSleep() ? kMaskTopic : kPassiveMaskTopic, kMaskQueue);
    rotation_->start();
  }

  void unsubscribeInputs() override {
    if (masks_) masks_->listenTo("");
    if (rotation_) rotation_->stop();
  }

  void process(const Job& job) override {
    const std_msgs::Header& header = job.frame.left->header;
    const std::optional<Eigen::Isometry3d> T_base_cam = extrinsic(job.frame);
    if (!T_base_cam) return;

    StageTimes times;
    Stopwatch watch;
    const std::optional<Eigen::Matrix3d> R_cam_prev = rotation_->since(last_stamp_, header);
    watch.lap("waiting for the rotation", times);
    const sensor_msgs::ImageConstPtr mask = masks_->history().of(last_stamp_);
    const EgoMotionProcessor::Output output =
        processor_->process(job.frame, *T_base_cam, usableMask(mask, *job.frame.left), R_cam_prev);
    watch.lap("ego-motion", times);
    if (!tell(output.sequence)) return;
    // Images that repeat show no motion, whatever the gyroscope measures.
    if (!output.repeated) rotation_->learnBias(last_stamp_, header.stamp, output.estimate);
    outputs_->publish(output);
    if (params_.publish_tf) tf_output_.publish(output.transform, *health_, arrivals_);
    report(output);
    last_stamp_ = header.stamp;
    finish(job, times, "pairs", "left images");
  }

  std::optional<Eigen::Isometry3d> extrinsic(const StereoPair& pair) {
    std::string error;
    const auto T_base_cam = arrivals_.waitFor(
        params_.transform_timeout, [&] { return processor_->extrinsic(tf_->buffer, pair, error); });
    const std::string base = processor_->baseFrame(pair), camera = pair.left->header.frame_id;
    const std::string cure =
        isLate(tf_->buffer, base, camera, pair.left->header.stamp)
            ? std::string(" at the image's stamp within transform_timeout. ") + kLateInTf
            : ": publish it (e.g. by tf2_ros static_transform_publisher), or set base_frame to '" +
                  camera + "' to take the camera itself as the base";
    health_->problem("extrinsic",
                     T_base_cam ? ""
                                : "no transform from base_frame '" + base +
                                      "' to the left camera '" + camera + "'" + cure,
                     Health::Severity::kBroken);
    if (T_base_cam) health_->problem("mount", doubtAboutMount(*T_base_cam, base, camera));
    return T_base_cam;
  }

  void report(const EgoMotionProcessor::Output& output) {
    const EgoMotionEstimate& estimate = output.estimate;
    const std::string why = describeLoss(output);
    health_->problem("tracking", why.empty() ? "" : "lost: " + why);
    health_->figure("pose", std::string(nameOf(output.pose_state)));
    health_->figure("features", estimate.features, "%.0f");
    health_->figure("inliers", estimate.inliers, "%.0f");
    health_->figure("residual [px]", estimate.residual_px, "%.3f");
    health_->figure("largest row offset [px]", estimate.row_alignment.largest_offset_px, "%.2f");
    reportColumns(estimate.column_offset);
  }

  std::string describeLoss(const EgoMotionProcessor::Output& output) const {
    if (output.frozen)
      return cv::format(
          "both images have been the same for more than max_gap = %g s. Does the camera driver "
          "hang, or are both lenses covered? (A simulator needs image noise.)",
          params_.max_gap);
    if (!output.stuck.empty())
      return "the " + output.stuck +
             " image is that of the pair before, the other one is not. Does the driver of the " +
             output.stuck +
             " camera hang, or is its lens covered? (The pose goes on with the last "
             "velocity.)";
    if (output.estimate.swapped)
      return "the left image shows what the right camera sees. Are the topics of left and right "
             "swapped? (The pose goes on with the last velocity.)";
    const bool goes_on = output.sequence.verdict == SequenceGuard::Verdict::kContinues;
    if (goes_on && output.pose_state != PoseState::kKnown)
      return "too few features agree on a motion. Are the images dark, blurred, without texture, "
             "or not rectified, or the lenses covered? (The pose goes on with the last velocity.)";
    return "";
  }

  void reportColumns(const ColumnOffset& columns) {
    if (!columns.known) return;
    health_->figure("column offset [px]", columns.offset_px, "%.2f");
    health_->figure("column offset sigma [px]", columns.sigma_px, "%.2f");
    const bool fits = std::abs(columns.offset_px) - 2 * columns.sigma_px <= kLargestColumnOffsetPx;
    health_->problem(
        "calibration",
        fits ? ""
             : cv::format("the right image is shifted by %.1f px (sigma %.1f) to the right of its "
                          "calibration, and all disparities are too small by as much: calibrate "
                          "the cameras again, or add %.1f to P[2] of right/camera_info",
                          columns.offset_px, columns.sigma_px, columns.offset_px));
  }

  static constexpr double kLargestColumnOffsetPx = 0.5;

  TfOutput tf_output_;
  std::optional<MessageInput<sensor_msgs::Image>> masks_;
  std::optional<RotationInput> rotation_;
  ros::Time last_stamp_;
};

}  // namespace
}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::EgoMotionNodelet, nodelet::Nodelet)
