#include "nodelets/ego_motion_processor.h"

#include <boost/make_shared.hpp>

#include "nodelets/transforms.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

const Matrix6d kUnknown = kUnknownCovariance * Matrix6d::Identity();

// From optical axes (x right, y down, z ahead) to body axes (x ahead, y left, z up; REP 103).
Eigen::Isometry3d bodyFromOptical() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return T;
}

PipelineParams pipelineParams(const EgoMotionProcessorParams& params) {
  PipelineParams pipeline;
  pipeline.parts = {true, false, false};
  pipeline.max_gap = params.max_gap;
  pipeline.ego_motion = params.ego_motion;
  return pipeline;
}

}  // namespace

EgoMotionProcessor::EgoMotionProcessor(const EgoMotionProcessorParams& params)
    : params_(params), pipeline_(pipelineParams(params)) {
  validate(params);
}

bool EgoMotionProcessor::cameraIsBase(const StereoPair& pair) const {
  return params_.base_frame.empty() || params_.base_frame == pair.left->header.frame_id;
}

std::string EgoMotionProcessor::baseFrame(const StereoPair& pair) const {
  return params_.base_frame.empty() ? pair.left->header.frame_id : params_.base_frame;
}

EgoMotionProcessor::Output EgoMotionProcessor::process(
    const StereoPair& pair, const Eigen::Isometry3d& T_base_cam, const cv::Mat1b& moving_mask,
    const std::optional<Eigen::Matrix3d>& R_cam_prev) {
  const StereoFrame frame = stereoFrame(pair, left_buffer_, right_buffer_);
  Output output;
  output.sequence = pipeline_.begin(frame);
  if (output.sequence.verdict == SequenceGuard::Verdict::kDuplicate) return output;
  if (pipeline_.isOrigin()) setOrigin(pair, T_base_cam);
  FrameSources sources;
  sources.ignored = moving_mask;
  sources.R_cam_prev = R_cam_prev;
  pipeline_.process(sources, output_);
  output.estimate = output_.ego_motion;
  applyMotion(T_base_cam, frame.stamp);
  frozen_ = isFrozen(pair);
  output.frozen = frozen_;
  output.messages = messages(pair);
  return output;
}

// Because of noise, consecutive images of a live camera always differ, also of a static scene.
bool EgoMotionProcessor::isFrozen(const StereoPair& pair) {
  const ros::Time stamp = pair.left->header.stamp;
  const bool repeated =
      last_left_ && last_left_->data == pair.left->data && last_right_->data == pair.right->data;
  if (!repeated || stamp < last_change_) last_change_ = stamp;
  last_left_ = pair.left;
  last_right_ = pair.right;
  return (stamp - last_change_).toSec() > params_.max_gap;
}

void EgoMotionProcessor::setOrigin(const StereoPair& pair, const Eigen::Isometry3d& T_base_cam) {
  T_odom_base_ = cameraIsBase(pair) ? bodyFromOptical() : Eigen::Isometry3d::Identity();
  pipeline_.setOrigin(compose(T_odom_base_, T_base_cam));
  pose_covariance_ = PathCovariance();
}

void EgoMotionProcessor::applyMotion(const Eigen::Isometry3d& T_base_cam, Stamp stamp) {
  twist_.setZero();
  twist_covariance_ = kUnknown;
  // A first frame gives no motion either: the pose keeps its value.
  if (!output_.motion_start) return;

  const CameraMotion& motion = output_.ego_motion.motion;
  const double dt_s = toSeconds(stamp - *output_.motion_start);
  const Eigen::Isometry3d T_odom_prev = T_odom_base_;
  T_odom_base_ = compose(output_.T_odom_cam, T_base_cam.inverse());
  const Eigen::Isometry3d T_prev_base = relative(T_odom_prev, T_odom_base_);

  // A left perturbation of T_cam_prev is a right perturbation of the camera's pose.
  const Matrix6d A = adjoint(T_base_cam);
  const Matrix6d step_covariance = A * motion.covariance * A.transpose();
  pose_covariance_.add({T_prev_base.inverse(), step_covariance},
                       A * output_.ego_motion.common_errors);
  twist_ = constantTwist(T_prev_base, dt_s);
  twist_covariance_ = step_covariance / (dt_s * dt_s);
}

EgoMotionMessages EgoMotionProcessor::messages(const StereoPair& pair) const {
  EgoMotionMessages result;
  std_msgs::Header header;
  header.stamp = pair.left->header.stamp;
  header.frame_id = params_.odom_frame;

  // ROS has pose covariances in the axes of the header's frame, about the base's origin.
  Matrix6d R = Matrix6d::Zero();
  R.topLeftCorner<3, 3>() = T_odom_base_.linear();
  R.bottomRightCorner<3, 3>() = T_odom_base_.linear();

  result.odometry = boost::make_shared<nav_msgs::Odometry>();
  result.odometry->header = header;
  result.odometry->child_frame_id = baseFrame(pair);
  result.odometry->pose.pose = poseMsg(T_odom_base_);
  result.odometry->pose.covariance = covarianceMsg(
      output_.pose_known && !frozen_ ? Matrix6d(R * pose_covariance_.covariance() * R.transpose())
                                     : kUnknown);
  result.odometry->twist.twist.linear.x = twist_(0);
  result.odometry->twist.twist.linear.y = twist_(1);
  result.odometry->twist.twist.linear.z = twist_(2);
  result.odometry->twist.twist.angular.x = twist_(3);
  result.odometry->twist.twist.angular.y = twist_(4);
  result.odometry->twist.twist.angular.z = twist_(5);
  result.odometry->twist.covariance = covarianceMsg(frozen_ ? kUnknown : twist_covariance_);

  result.pose = boost::make_shared<geometry_msgs::PoseWithCovarianceStamped>();
  result.pose->header = header;
  result.pose->pose = result.odometry->pose;

  result.transform.header = header;
  result.transform.child_frame_id = baseFrame(pair);
  result.transform.transform = transformMsg(T_odom_base_);

  result.row_alignment = rowAlignmentMsg(output_.ego_motion.row_alignment,
                                         output_.ego_motion.column_offset, pair.left->header);
  return result;
}

}  // namespace predictive_stereo
