#include "nodelets/ego_motion_processor.h"

#include <boost/make_shared.hpp>

#include "nodelets/transforms.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

const Matrix6d kUnknown = kUnknownCovariance * Matrix6d::Identity();

// x ahead, y left, z up (REP 103) from a camera's x right, y down, z ahead.
Eigen::Isometry3d bodyFromOptical() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return T;
}

}  // namespace

EgoMotionProcessor::EgoMotionProcessor(const EgoMotionProcessorParams& params)
    : params_(params), ego_motion_(params.ego_motion), guard_(params.max_gap) {
  validate(params);
}

void EgoMotionProcessor::setParams(const EgoMotionParams& params) {
  ego_motion_.setParams(params);
  params_.ego_motion = params;
}

void EgoMotionProcessor::reset() {
  startAnew();
  guard_.forget();
}

// EgoMotion::reset() would keep what it learnt of the calibration.
void EgoMotionProcessor::startAnew() {
  ego_motion_ = EgoMotion(params_.ego_motion);
  started_ = false;
}

bool EgoMotionProcessor::cameraIsBase(const StereoPair& pair) const {
  return params_.base_frame.empty() || params_.base_frame == pair.left->header.frame_id;
}

std::string EgoMotionProcessor::baseFrame(const StereoPair& pair) const {
  return params_.base_frame.empty() ? pair.left->header.frame_id : params_.base_frame;
}

EgoMotionProcessor::Output EgoMotionProcessor::process(const StereoPair& pair,
                                                       const Eigen::Isometry3d& T_base_cam,
                                                       const cv::Mat1b& moving_mask) {
  const StereoRig rig = stereoRig(pair);
  const cv::Mat1b left = greyImage(*pair.left, "left", left_buffer_);
  const cv::Mat1b right = greyImage(*pair.right, "right", right_buffer_);

  Output output;
  output.sequence = guard_.next(pair.left->header.stamp, rig);
  switch (output.sequence.verdict) {
    case SequenceGuard::Verdict::kDuplicate:
      return output;
    case SequenceGuard::Verdict::kBackward:
      startAnew();
      break;
    case SequenceGuard::Verdict::kFirst:
    case SequenceGuard::Verdict::kBroken:
      ego_motion_.reset();
      break;
    case SequenceGuard::Verdict::kContinues:
      break;
  }
  if (!started_) setOrigin(pair, T_base_cam);
  const bool use_mask = moving_mask.size() == left.size() &&
                        output.sequence.verdict == SequenceGuard::Verdict::kContinues;
  output.estimate = ego_motion_.estimate(left, right, rig, use_mask ? moving_mask : cv::Mat1b());
  move(output.estimate, T_base_cam, (pair.left->header.stamp - last_tracked_).toSec());
  if (!lost_) last_tracked_ = pair.left->header.stamp;
  output.messages = messages(pair);
  return output;
}

void EgoMotionProcessor::setOrigin(const StereoPair& pair, const Eigen::Isometry3d& T_base_cam) {
  T_odom_base_ = cameraIsBase(pair) ? bodyFromOptical() : Eigen::Isometry3d::Identity();
  T_odom_cam_ = compose(T_odom_base_, T_base_cam);
  pose_covariance_.setZero();
  started_ = true;
}

void EgoMotionProcessor::move(const EgoMotionEstimate& estimate,
                              const Eigen::Isometry3d& T_base_cam, double dt_s) {
  lost_ = estimate.status == EgoMotionStatus::kLost;
  twist_.setZero();
  twist_covariance_ = kUnknown;
  // A first frame says nothing of the motion either: the pose is held.
  if (estimate.status != EgoMotionStatus::kTracked) return;

  const Eigen::Isometry3d T_odom_prev = T_odom_base_;
  T_odom_cam_ = compose(T_odom_cam_, estimate.motion.T_cam_prev.inverse());
  T_odom_base_ = compose(T_odom_cam_, T_base_cam.inverse());
  const Eigen::Isometry3d T_prev_base = relative(T_odom_prev, T_odom_base_);

  // A perturbation on the left of T_cam_prev is one on the right of the camera's pose.
  const Matrix6d A = adjoint(T_base_cam);
  const Matrix6d step_covariance = A * estimate.motion.covariance * A.transpose();
  const Matrix6d carry = adjoint(T_prev_base.inverse());
  pose_covariance_ = carry * pose_covariance_ * carry.transpose() + step_covariance;
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
  result.odometry->pose.covariance =
      covarianceMsg(lost_ ? kUnknown : Matrix6d(R * pose_covariance_ * R.transpose()));
  result.odometry->twist.twist.linear.x = twist_(0);
  result.odometry->twist.twist.linear.y = twist_(1);
  result.odometry->twist.twist.linear.z = twist_(2);
  result.odometry->twist.twist.angular.x = twist_(3);
  result.odometry->twist.twist.angular.y = twist_(4);
  result.odometry->twist.twist.angular.z = twist_(5);
  result.odometry->twist.covariance = covarianceMsg(twist_covariance_);

  result.pose = boost::make_shared<geometry_msgs::PoseWithCovarianceStamped>();
  result.pose->header = header;
  result.pose->pose = result.odometry->pose;

  result.transform.header = header;
  result.transform.child_frame_id = baseFrame(pair);
  result.transform.transform = transformMsg(T_odom_base_);
  return result;
}

}  // namespace predictive_stereo
