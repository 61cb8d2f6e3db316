/// What an error of the camera's motion does to static points.
#pragma once

#include <Eigen/Geometry>

#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {

/// Standard deviations of a camera motion whose covariance its source does not tell.
constexpr double kUntoldMotionSigma_m = 0.015, kUntoldMotionSigma_rad = 0.0002;

/// `covariance` if it is one (finite, symmetric, with positive variances only); otherwise that of
/// a motion whose source does not tell it.
/// @param covariance  see CameraMotion::covariance.
Matrix6d toldCovariance(const Matrix6d& covariance);

/// Covariance of a point's position in the past camera's frame [m^2].
/// @param T_past_cam  the camera's motion, with the error that `covariance` describes, in the
///   current camera's frame.
/// @param point_m  in the current camera's frame.
Eigen::Matrix3d pointCovariance(const Eigen::Isometry3d& T_past_cam, const Matrix6d& covariance,
                                const Eigen::Vector3d& point_m);

/// Variance of the depth that a point has in the past camera's frame, see pointCovariance; for many
/// points of one motion.
class PastDepthNoise {
 public:
  PastDepthNoise(const Eigen::Isometry3d& T_past_cam, const Matrix6d& covariance);

  /// @param x, y  direction of the point (x, y, 1) in the current camera's frame.
  /// @param depth_m  in that frame.
  /// @returns [m^2].
  float variance(float x, float y, float depth_m) const {
    const Eigen::Vector3f q(x, y, 1);
    return translation_ + depth_m * (2 * coupling_.dot(q) + depth_m * q.dot(rotation_ * q));
  }

 private:
  float translation_;
  Eigen::Vector3f coupling_;
  Eigen::Matrix3f rotation_;
};

}  // namespace predictive_stereo
