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
  const OdometryOutput& followed = odometry_.follow({moving_mask, R_cam_prev, T_base_cam});
  output.estimate = followed.ego_motion;
  output.repeated = repeatsLast(pair);
  const ros::Time stamp = pair.left->header.stamp;
  if (!output.repeated || stamp < last_change_) last_change_ = stamp;
  output.frozen = (stamp - last_change_).toSec() > params_.max_gap;
  output.pose_state = output.frozen ? PoseState::kLost : followed.pose.state;
  makeMessages(pair, followed.pose, output);
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

void EgoMotionProcessor::makeMessages(const StereoPair& pair, const PoseEstimate& pose,
                                      Output& output) const {
  std_msgs::Header header;
  header.stamp = pair.left->header.stamp;
  header.frame_id = params_.odom_frame;

  const Velocity twist =
      !pose.velocity || output.frozen ? Velocity{Vector6d::Zero(), kUnknown} : *pose.velocity;
  // ROS has pose covariances in the axes of the header's frame, about the base's origin.
  Matrix6d R = Matrix6d::Zero();
  R.topLeftCorner<3, 3>() = pose.T_odom_body.linear();
  R.bottomRightCorner<3, 3>() = pose.T_odom_body.linear();

  output.odometry = boost::make_shared<nav_msgs::Odometry>();
  output.odometry->header = header;
  output.odometry->child_frame_id = baseFrame(pair);
  output.odometry->pose.pose = tf2::toMsg(pose.T_odom_body);
  output.odometry->pose.covariance =
      covarianceMsg(output.frozen ? kUnknown : Matrix6d(R * pose.covariance * R.transpose()));
  output.odometry->twist.twist = tf2::toMsg(twist.twist);
  output.odometry->twist.covariance = covarianceMsg(twist.covariance);

  output.pose = boost::make_shared<geometry_msgs::PoseWithCovarianceStamped>();
  output.pose->header = header;
  output.pose->pose = output.odometry->pose;

  output.transform =
      transformMsg(header.stamp, params_.odom_frame, baseFrame(pair), pose.T_odom_body);

  output.row_alignment = rowAlignmentMsg(output.estimate.row_alignment,
                                         output.estimate.column_offset, pair.left->header);
}

}  // namespace predictive_stereo
