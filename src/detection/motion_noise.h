/// What an error of the camera's motion does to static points.
#pragma once

#include <Eigen/Geometry>

#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {

/// `covariance` if it is one (finite, symmetric, with positive variances only); otherwise that of
/// a motion whose source does not tell it.
/// @param covariance  see CameraMotion::covariance.
Matrix6d toldCovariance(const Matrix6d& covariance);

/// Whether nobody saw the motion, see unseenCovariance: nothing from before it can be compared.
bool isUnseen(const Matrix6d& covariance);

/// Covariance of a point's position in the past camera's frame [m^2].
/// @param T_past_cam  the camera's motion, with the error that `covariance` describes, in the
///   current camera's frame.
/// @param point_m  in the current camera's frame.
Eigen::Matrix3d pointCovariance(const Eigen::Isometry3d& T_past_cam, const Matrix6d& covariance,
                                const Eigen::Vector3d& point_m);

/// Variance of the depth in a past camera's frame of points on one row, see PastDepthNoise.
struct DepthNoiseOfRow {
  float fixed;
  float coupling[2];  ///< coefficients of x^0, x^1
  float rotation[3];  ///< coefficients of x^0, x^1, x^2

  /// Of the point z (x, y, 1) m [m^2].
  float variance(float x, float z) const {
    const float by_coupling = coupling[0] + x * coupling[1];
    const float by_rotation = rotation[0] + x * (rotation[1] + x * rotation[2]);
    return fixed + z * (2 * by_coupling + z * by_rotation);
  }
};

/// Variance of the depth that a point has in the past camera's frame, see pointCovariance; for many
/// points of one motion.
class PastDepthNoise {
 public:
  PastDepthNoise(const Eigen::Isometry3d& T_past_cam, const Matrix6d& covariance);

  /// Of the points z (x, y, 1) m with this y, in the current camera's frame.
  DepthNoiseOfRow along(float y) const {
    const Eigen::Vector3f q(0, y, 1);
    return {translation_,
            {coupling_.dot(q), coupling_.x()},
            {q.dot(rotation_ * q), 2 * rotation_.row(0).dot(q), rotation_(0, 0)}};
  }

 private:
  float translation_;
  Eigen::Vector3f coupling_;
  Eigen::Matrix3f rotation_;
};

}  // namespace predictive_stereo
