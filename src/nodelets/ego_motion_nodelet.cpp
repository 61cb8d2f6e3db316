#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <sstream>
#include <string>

#include "nodelets/frame_nodelet.h"
#include "nodelets/mask_input.h"
#include "nodelets/output_topics.h"
#include "nodelets/rotation_prior.h"
#include "nodelets/tf_output.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {

/// Odometry of a stereo camera.
///
/// Subscribes: left/image_rect, left/camera_info, right/image_rect, right/camera_info; imu if
///   ~use_imu is set; moving_objects/mask if ~use_moving_mask is set (moving_objects/passive_mask
///   if this nodelet can sleep).
/// Publishes: odometry, odometry/pose, odometry/row_alignment, /tf (odom_frame -> base_frame),
///   /diagnostics. If ~publish_tf is false or ~lazy is true, it subscribes only to /tf while the
///   first three have no subscribers. It does not publish tf if another node already publishes
///   base_frame there.
/// Services: ~reset (the next frame is the origin), and those of dynamic_reconfigure.
/// Parameters: EgoMotionNodeletParams.
class EgoMotionNodelet : public FrameNodelet<EgoMotionNodeletParams, StereoInput,
                                             EgoMotionProcessor, EgoMotion, EgoMotionParams> {
 public:
  EgoMotionNodelet()
      : FrameNodelet("EgoMotion", "ego_motion", &EgoMotionNodeletParams::ego_motion, {}) {}
  ~EgoMotionNodelet() override { shutDown(); }

 private:
  TfInput::Listener tfListener() override {
    return [this](const geometry_msgs::TransformStamped& transform, const std::string& publisher,
                  bool is_static) {
      tf_output_.rivals().addTransform(transform, publisher, is_static);
    };
  }

  void connect(ros::NodeHandle& node) override {
    if (params_.publish_tf) tf_output_.start(node);
    masks_ = std::make_unique<MaskInput>(node, *health_, arrivals_);
    rotation_ = std::make_unique<RotationPrior>(node, *health_, arrivals_, *tf_, params_);
    makeInput(node, params_.sync);
    alignment_.emplace(node, [this] { updateDemand(); });
    visitEgoMotionOutputs(*outputs_, *alignment_);
  }

  // It is unknown whether a node needs its transforms.
  bool mustNotSleep() const { return params_.publish_tf && !params_.lazy; }
  bool wanted() const override {
    return mustNotSleep() || outputs_->wanted() || alignment_->wanted();
  }

  void subscribeInputs() override {
    // MovingObjects needs this nodelet. If each kept the other one awake, neither would ever sleep.
    if (params_.use_moving_mask)
      masks_->listenTo(mustNotSleep() ? MaskInput::kTopic : MaskInput::kPassiveTopic);
    rotation_->start();
  }

  void unsubscribeInputs() override {
    if (masks_) masks_->stop();
    if (rotation_) rotation_->stop();
  }

  void process(const Job& job) override {
    const std_msgs::Header& header = job.frame.left->header;
    if (header.frame_id.empty()) throw std::invalid_argument(kNoFrame);
    const std::optional<Eigen::Isometry3d> T_base_cam = extrinsic(job.frame);
    if (!T_base_cam) return;

    StageTimes times;
    Stopwatch watch;
    const std::optional<Eigen::Matrix3d> R_cam_prev = rotation_->since(last_stamp_, header);
    watch.lap("waiting for the rotation", times);
    const sensor_msgs::ImageConstPtr mask = masks_->at(last_stamp_);
    const EgoMotionProcessor::Output output = processor_->process(
        job.frame, *T_base_cam, masks_->usable(mask, *job.frame.left), R_cam_prev);
    watch.lap("ego-motion", times);
    tell(output.sequence);
    if (output.sequence.isIgnored()) return;
    // Images that repeat show no motion, whatever the gyroscope measures.
    if (!output.repeated) rotation_->learnBias(last_stamp_, header.stamp, output.estimate);
    // The alignment is first: a node that waits for the motion then has it for its next frame.
    alignment_->publish(output);
    if (params_.publish_tf) tf_output_.publish(output.transform, *health_, arrivals_);
    outputs_->publish(output);
    report(output);
    last_stamp_ = header.stamp;
    finish(job, times, "pairs", "left images");
  }

  std::optional<Eigen::Isometry3d> extrinsic(const StereoPair& pair) {
    if (processor_->cameraIsBase(pair)) return Eigen::Isometry3d::Identity();
    const std::string base = processor_->baseFrame(pair);
    const std::string& camera = pair.left->header.frame_id;
    std::string error;
    const auto T_base_cam = arrivals_.waitFor(params_.transform_timeout, [&] {
      return lookUpTransform(tf_->buffer, base, camera, pair.left->header.stamp, error);
    });
    if (T_base_cam)
      health_->solved("extrinsic");
    else
      health_->problem("extrinsic",
                       "no transform from base_frame '" + base + "' to the left camera '" + camera +
                           "': publish it (e.g. by tf2_ros static_transform_publisher), or set "
                           "base_frame to '" +
                           camera + "' to take the camera itself as the base",
                       Health::Severity::kBroken);
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
    if (output.frozen) {
      std::ostringstream text;
      text << "both images have been the same for more than max_gap = " << params_.max_gap
           << " s. Does the camera driver hang? (A simulator needs image noise.)";
      return text.str();
    }
    if (output.estimate.swapped)
      return "the left image shows what the right camera sees. Are the topics of left and right "
             "swapped? (The pose goes on with the last velocity.)";
    const bool goes_on = output.sequence.verdict == SequenceGuard::Verdict::kContinues;
    if (goes_on && output.pose_state != PoseState::kKnown)
      return "too few features agree on a motion; the pose goes on with the last velocity";
    return "";
  }

  void reportColumns(const ColumnOffset& columns) {
    if (!columns.known) return;
    health_->figure("column offset [px]", columns.offset_px, "%.2f");
    health_->figure("column offset sigma [px]", columns.sigma_px, "%.2f");
    if (std::abs(columns.offset_px) - 2 * columns.sigma_px <= kLargestColumnOffsetPx) {
      health_->solved("calibration");
      return;
    }
    char text[300];
    std::snprintf(
        text, sizeof text,
        "the right image is shifted by %.1f px (sigma %.1f) to the right of its calibration, and "
        "all disparities are too small by as much: calibrate the cameras again, or add %.1f to "
        "P[2] of right/camera_info",
        columns.offset_px, columns.sigma_px, columns.offset_px);
    health_->problem("calibration", text);
  }

  static constexpr double kLargestColumnOffsetPx = 0.5;

  std::optional<Outputs<EgoMotionProcessor::Output>> alignment_;
  TfOutput tf_output_;
  std::unique_ptr<MaskInput> masks_;
  std::unique_ptr<RotationPrior> rotation_;
  ros::Time last_stamp_;
};

}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::EgoMotionNodelet, nodelet::Nodelet)
