#pragma once

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/RowAlignment.h>

#include <optional>
#include <string>

#include "nodelets/nodelet_params.h"
#include "nodelets/stereo_messages.h"
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
  };

  explicit EgoMotionProcessor(const EgoMotionNodeletParams& params);

  /// @param T_base_cam  of the left camera's optical frame at the pair's stamp.
  /// @param moving_mask  255 on moving objects of the previous frame; empty: unknown.
  /// @param R_cam_prev  from another source, see EgoMotion::estimate.
  /// @throws std::invalid_argument for a pair that cannot be used; the state stays as it was.
  Output process(const StereoPair& pair, const Eigen::Isometry3d& T_base_cam,
                 const cv::Mat1b& moving_mask = {},
                 const std::optional<Eigen::Matrix3d>& R_cam_prev = {});

  /// See VisualOdometry::setParams.
  void setParams(const EgoMotionParams& params) { odometry_.setParams(params); }

  /// Resets the state: the next frame is the origin.
  void reset() { odometry_.reset(); }

  /// The frame whose pose is published, for pairs of this camera.
  std::string baseFrame(const StereoPair& pair) const {
    return params_.base_frame.empty() ? pair.left->header.frame_id : params_.base_frame;
  }
  bool cameraIsBase(const StereoPair& pair) const {
    return baseFrame(pair) == pair.left->header.frame_id;
  }

 private:
  bool repeatsLast(const StereoPair& pair);
  void makeMessages(const StereoPair& pair, const PoseEstimate& pose, Output& output) const;

  EgoMotionNodeletParams params_;
  VisualOdometry odometry_;
  cv::Mat1b left_buffer_, right_buffer_;

  sensor_msgs::ImageConstPtr last_left_, last_right_;
  ros::Time last_change_;  // of the images
};

}  // namespace predictive_stereo
