#include "nodelets/ego_motion_processor.h"

#include <tf2_eigen/tf2_eigen.h>

#include <boost/make_shared.hpp>

#include "nodelets/transforms.h"

namespace predictive_stereo {
namespace {

const Matrix6d kUnknown = kUnknownCovariance * Matrix6d::Identity();

// From optical axes (x right, y down, z ahead) to body axes (x ahead, y left, z up; REP 103).
Eigen::Isometry3d bodyFromOptical() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return T;
}

}  // namespace

EgoMotionProcessor::EgoMotionProcessor(const EgoMotionNodeletParams& params)
    : params_(params), odometry_(params.ego_motion, params.max_gap) {
  validate(params);
}

EgoMotionProcessor::Output EgoMotionProcessor::process(
    const StereoPair& pair, const Eigen::Isometry3d& T_base_cam, const cv::Mat1b& moving_mask,
    const std::optional<Eigen::Matrix3d>& R_cam_prev) {
  const StereoFrame frame = stereoFrame(pair, left_buffer_, right_buffer_);
  Output output;
  output.sequence = odometry_.begin(frame);
  if (output.sequence.isIgnored()) return output;
  if (odometry_.isOrigin())
    odometry_.setOrigin(cameraIsBase(pair) ? bodyFromOptical() : Eigen::Isometry3d::Identity());
  output_ = odometry_.follow({moving_mask, R_cam_prev, T_base_cam});
  output.estimate = output_.ego_motion;
  output.repeated = repeatsLast(pair);
  const ros::Time stamp = pair.left->header.stamp;
  if (!output.repeated || stamp < last_change_) last_change_ = stamp;
  frozen_ = (stamp - last_change_).toSec() > params_.max_gap;
  output.frozen = frozen_;
  output.pose_state = frozen_ ? PoseState::kLost : output_.pose.state;
  output.messages = messages(pair);
  return output;
}

// Because of noise, consecutive images of a live camera always differ, also of a static scene.
bool EgoMotionProcessor::repeatsLast(const StereoPair& pair) {
  const bool repeats =
      last_left_ && last_left_->data == pair.left->data && last_right_->data == pair.right->data;
  last_left_ = pair.left;
  last_right_ = pair.right;
  return repeats;
}

EgoMotionMessages EgoMotionProcessor::messages(const StereoPair& pair) const {
  EgoMotionMessages result;
  std_msgs::Header header;
  header.stamp = pair.left->header.stamp;
  header.frame_id = params_.odom_frame;

  const PoseEstimate& pose = output_.pose;
  const Velocity twist =
      !pose.velocity || frozen_ ? Velocity{Vector6d::Zero(), kUnknown} : *pose.velocity;
  // ROS has pose covariances in the axes of the header's frame, about the base's origin.
  Matrix6d R = Matrix6d::Zero();
  R.topLeftCorner<3, 3>() = pose.T_odom_body.linear();
  R.bottomRightCorner<3, 3>() = pose.T_odom_body.linear();

  result.odometry = boost::make_shared<nav_msgs::Odometry>();
  result.odometry->header = header;
  result.odometry->child_frame_id = baseFrame(pair);
  result.odometry->pose.pose = tf2::toMsg(pose.T_odom_body);
  result.odometry->pose.covariance =
      covarianceMsg(frozen_ ? kUnknown : Matrix6d(R * pose.covariance * R.transpose()));
  result.odometry->twist.twist = tf2::toMsg(twist.twist);
  result.odometry->twist.covariance = covarianceMsg(twist.covariance);

  result.pose = boost::make_shared<geometry_msgs::PoseWithCovarianceStamped>();
  result.pose->header = header;
  result.pose->pose = result.odometry->pose;

  result.transform.header = header;
  result.transform.child_frame_id = baseFrame(pair);
  result.transform.transform = transformMsg(pose.T_odom_body);

  result.row_alignment = rowAlignmentMsg(output_.ego_motion.row_alignment,
                                         output_.ego_motion.column_offset, pair.left->header);
  return result;
}

}  // namespace predictive_stereo
