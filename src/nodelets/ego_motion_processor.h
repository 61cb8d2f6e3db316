#pragma once

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/RowAlignment.h>
#include <tf2_eigen/tf2_eigen.h>

#include <boost/make_shared.hpp>
#include <optional>
#include <string>

#include "nodelets/nodelet_params.h"
#include "nodelets/stereo_messages.h"
#include "nodelets/transforms.h"
#include "predictive_stereo/visual_odometry.h"

namespace predictive_stereo {

/// Odometry messages from pairs; used by the EgoMotion nodelet and by `replay`.
///
/// The pose starts at the origin, with the axes of the base frame. If the camera is the base, these
/// are the camera's axes in the convention of REP 103: x ahead, z up. While the ego-motion is lost,
/// the pose goes on with the last velocity, and its covariance grows (see CameraPath); the twist is
/// zero, with a covariance of kUnknownCovariance.
class EgoMotionProcessor {
 public:
  struct Output {
    SequenceGuard::Result sequence;
    // nullptr for a pair that is ignored.
    nav_msgs::OdometryPtr odometry;
    geometry_msgs::PoseWithCovarianceStampedPtr pose;
    geometry_msgs::TransformStamped transform;  ///< odom_frame -> base frame
    RowAlignment::Ptr row_alignment;            ///< its column offset is for the following frames

    PoseState pose_state = PoseState::kLost;  ///< kLost if frozen
    EgoMotionEstimate estimate;
    bool repeated = false;  ///< both images are those of the pair before
    bool frozen = false;    ///< they have been the same for more than max_gap
    std::string stuck;      ///< "left" or "right": only this image is; nothing is measured then
  };

  explicit EgoMotionProcessor(const EgoMotionNodeletParams& params)
      : params_(params),
        robot_mask_(readRobotMask(params.robot_mask)),
        odometry_(params.ego_motion, params.max_gap) {
    validate(params);
  }

  /// @param T_base_cam  of the left camera's optical frame at the pair's stamp.
  /// @param moving_mask  255 on moving objects of the previous frame; empty: unknown.
  /// @param R_cam_prev  from another source, see EgoMotion::estimate.
  /// @throws std::invalid_argument for a pair that cannot be used; the state stays as it was.
  Output process(const StereoPair& pair, const Eigen::Isometry3d& T_base_cam,
                 const cv::Mat1b& moving_mask = {},
                 const std::optional<Eigen::Matrix3d>& R_cam_prev = {}) {
    StereoFrame frame = stereoFrame(pair, robot_mask_);
    Output output;
    // Because of noise, consecutive images of a live camera always differ, also of a static scene.
    const bool same_left = last_left_ && last_left_->data == pair.left->data;
    const bool same_right = last_right_ && last_right_->data == pair.right->data;
    output.repeated = same_left && same_right;
    if (same_left != same_right) {
      output.stuck = same_left ? "left" : "right";  // nothing is measured: all is masked
      frame.robot_mask = cv::Mat1b(frame.left.size(), uint8_t{255});
    }
    output.sequence = odometry_.begin(frame);
    if (output.sequence.isIgnored()) return output;
    last_left_ = pair.left;
    last_right_ = pair.right;
    if (odometry_.isOrigin())
      odometry_.setOrigin(
          Eigen::Isometry3d(cameraIsBase(pair) ? bodyFromOptical() : Eigen::Matrix3d::Identity()));
    const OdometryOutput& followed = odometry_.follow({moving_mask, R_cam_prev, T_base_cam});
    output.estimate = followed.ego_motion;
    const ros::Time stamp = pair.left->header.stamp;
    if (!output.repeated || stamp < last_change_) last_change_ = stamp;
    output.frozen = (stamp - last_change_).toSec() > params_.max_gap;
    output.pose_state = output.frozen ? PoseState::kLost : followed.pose.state;
    makeMessages(pair, followed.pose, output);
    return output;
  }

  /// See VisualOdometry::setParams.
  void setParams(const EgoMotionParams& params) { odometry_.setParams(params); }

  /// Resets the state: the next frame is the origin.
  void reset() { odometry_.reset(); }

  /// The frame whose pose is published, for pairs of this camera.
  std::string baseFrame(const StereoPair& pair) const {
    return withoutSlash(params_.base_frame.empty() ? pair.left->header.frame_id
                                                   : params_.base_frame);
  }

  /// The pose of the left camera in that frame, from tf; none: `error` says why.
  /// @throws std::invalid_argument for an image without a frame_id, or if baseFrame() is
  /// odom_frame.
  std::optional<Eigen::Isometry3d> extrinsic(const tf2::BufferCore& tf, const StereoPair& pair,
                                             std::string& error) const {
    const std_msgs::Header& header = pair.left->header;
    if (header.frame_id.empty()) throw std::invalid_argument(kNoFrame);
    if (baseFrame(pair) == withoutSlash(params_.odom_frame))
      throw std::invalid_argument("odom_frame '" + params_.odom_frame +
                                  "' is the frame that moves in it: set another name");
    if (cameraIsBase(pair)) return Eigen::Isometry3d::Identity();
    return lookUpTransform(tf, baseFrame(pair), header.frame_id, header.stamp, error);
  }

 private:
  bool cameraIsBase(const StereoPair& pair) const {
    return baseFrame(pair) == withoutSlash(pair.left->header.frame_id);
  }

  void makeMessages(const StereoPair& pair, const PoseEstimate& pose, Output& output) const {
    std_msgs::Header header;
    header.stamp = pair.left->header.stamp;
    header.frame_id = withoutSlash(params_.odom_frame);

    const Matrix6d unknown = kUnknownCovariance * Matrix6d::Identity();
    const Velocity twist =
        !pose.velocity || output.frozen ? Velocity{Vector6d::Zero(), unknown} : *pose.velocity;
    // ROS has pose covariances in the axes of the header's frame, about the base's origin.
    Matrix6d R = Matrix6d::Zero();
    R.topLeftCorner<3, 3>() = pose.T_odom_body.linear();
    R.bottomRightCorner<3, 3>() = pose.T_odom_body.linear();

    output.odometry = boost::make_shared<nav_msgs::Odometry>();
    output.odometry->header = header;
    output.odometry->child_frame_id = baseFrame(pair);
    output.odometry->pose.pose = tf2::toMsg(pose.T_odom_body);
    output.odometry->pose.covariance =
        covarianceMsg(output.frozen ? unknown : Matrix6d(R * pose.covariance * R.transpose()));
    output.odometry->twist.twist = tf2::toMsg(twist.twist);
    output.odometry->twist.covariance = covarianceMsg(twist.covariance);

    output.pose = boost::make_shared<geometry_msgs::PoseWithCovarianceStamped>();
    output.pose->header = header;
    output.pose->pose = output.odometry->pose;

    output.transform =
        transformMsg(header.stamp, header.frame_id, baseFrame(pair), pose.T_odom_body);

    output.row_alignment = rowAlignmentMsg(output.estimate.row_alignment,
                                           output.estimate.column_offset, pair.left->header);
  }

  EgoMotionNodeletParams params_;
  const cv::Mat1b robot_mask_;
  VisualOdometry odometry_;

  sensor_msgs::ImageConstPtr last_left_, last_right_;
  ros::Time last_change_;  // of the images
};

}  // namespace predictive_stereo
