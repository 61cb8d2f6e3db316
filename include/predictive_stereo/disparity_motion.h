/// How the camera's motion moves points in disparity space.
#pragma once

#include <Eigen/Geometry>

#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// The camera's motion between two frames.
struct CameraMotion {
  /// Maps points of the previous left camera's optical frame into the current one's [m].
  Eigen::Isometry3d T_cam_prev = Eigen::Isometry3d::Identity();
  /// Covariance of a left-multiplied perturbation (translation [m], rotation [rad]) of T_cam_prev,
  /// expressed in the current camera frame; zero where unknown.
  Matrix6d covariance = Matrix6d::Zero();
};

/// The camera's pose, and how well its motion to there is known.
struct CameraPose {
  /// Of the left camera's optical frame in the odom frame.
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
  /// Of the motion since the previous frame with a known pose, see CameraMotion::covariance.
  Matrix6d motion_covariance = Matrix6d::Zero();
};

/// Variance of a motion that nobody has seen [m^2, rad^2].
constexpr double kUnseenVariance = 9999;
inline Matrix6d unseenCovariance() { return kUnseenVariance * Matrix6d::Identity(); }

/// Standard deviations of a motion from frame to frame whose source does not tell them.
constexpr double kUntoldMotionSigma_m = 0.015, kUntoldMotionSigma_rad = 0.0002;
/// Their covariance, along and about each axis.
inline Matrix6d untoldCovariance() {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(kUntoldMotionSigma_m),
      Eigen::Vector3d::Constant(kUntoldMotionSigma_rad);
  return sigmas.cwiseAbs2().asDiagonal();
}

/// H of the paper's eq. 2: maps homogeneous disparity-space points (x, y, d, 1) [px] of the
/// previous frame to the current one, up to scale. H = M^-1 T_cam_prev M, where M maps (x, y, d, 1)
/// to homogeneous Euclidean points (Demirdjian and Darrell 2001).
/// @param rig  with positive focal lengths and baseline; this is not checked.
/// @param T_cam_prev  see CameraMotion.
Eigen::Matrix4d disparityMotion(const StereoRig& rig, const Eigen::Isometry3d& T_cam_prev);

}  // namespace predictive_stereo
