#pragma once

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/RowAlignment.h>

#include <optional>
#include <string>

#include "nodelets/nodelet_params.h"
#include "nodelets/stereo_messages.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

struct EgoMotionMessages {
  nav_msgs::OdometryPtr odometry;
  geometry_msgs::PoseWithCovarianceStampedPtr pose;
  geometry_msgs::TransformStamped transform;  ///< odom_frame -> base frame
  RowAlignment::Ptr row_alignment;            ///< its columns are for the frames after this one
};

/// Odometry messages from pairs; what the EgoMotion nodelet and `replay` run.
///
/// The pose starts at the origin, with the base frame's axes (where the camera is the base, with
/// the camera's axes turned as REP 103 has them: x ahead, z up). While lost it is held.
class EgoMotionProcessor {
 public:
  struct Output {
    std::optional<EgoMotionMessages> messages;  ///< none for a duplicate
    EgoMotionEstimate estimate;
    SequenceGuard::Result sequence;
    bool frozen = false;  ///< both images have been the same for more than max_gap
  };

  explicit EgoMotionProcessor(const EgoMotionProcessorParams& params);

  /// @param T_base_cam  of the left camera's optical frame at the pair's stamp.
  /// @param moving_mask  255 on moving objects of the previous frame; empty: none known.
  /// @param R_cam_prev  of others, see EgoMotion::estimate.
  /// @throws std::invalid_argument for a pair that cannot be used; the state stays as it was.
  Output process(const StereoPair& pair, const Eigen::Isometry3d& T_base_cam,
                 const cv::Mat1b& moving_mask = {},
                 const std::optional<Eigen::Matrix3d>& R_cam_prev = {});

  /// See Pipeline::setParams.
  void setParams(const EgoMotionParams& params) { pipeline_.setParams(params); }

  /// Forgets everything: the next frame is the origin.
  void reset() { pipeline_.reset(); }

  /// The frame whose pose is given, for pairs of this camera.
  std::string baseFrame(const StereoPair& pair) const;
  bool cameraIsBase(const StereoPair& pair) const;

 private:
  bool isFrozen(const StereoPair& pair);
  void setOrigin(const StereoPair& pair, const Eigen::Isometry3d& T_base_cam);
  void move(const Eigen::Isometry3d& T_base_cam, Stamp stamp);
  EgoMotionMessages messages(const StereoPair& pair) const;

  EgoMotionProcessorParams params_;
  Pipeline pipeline_;
  PipelineOutput output_;
  cv::Mat1b left_buffer_, right_buffer_;

  sensor_msgs::ImageConstPtr last_left_, last_right_;
  ros::Time last_change_;  // of the images
  bool frozen_ = false;

  Eigen::Isometry3d T_odom_base_;
  PathCovariance pose_covariance_;  // of T_odom_base, perturbed in the base frame
  Vector6d twist_;
  Matrix6d twist_covariance_;
};

}  // namespace predictive_stereo
