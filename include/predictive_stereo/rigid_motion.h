/// Rotations, and products of rigid motions whose linear parts remain rotations.
#pragma once

#include <Eigen/Geometry>

namespace predictive_stereo {

/// T with its linear part made a rotation again. The linear part must be a rotation up to rounding
/// errors; this is not checked.
///
/// Isometry3d::inverse() transposes the linear part. In a feedback such as A <- A B, B <- A C^-1
/// the deviation from a rotation therefore grows exponentially: from rounding errors to a visible
/// error in 34 frames.
Eigen::Isometry3d orthonormal(const Eigen::Isometry3d& T);

/// T_a_c = T_a_b T_b_c, orthonormal. Use it wherever a product is kept and multiplied again.
/// T_a_b maps points [m] of frame b to frame a.
Eigen::Isometry3d compose(const Eigen::Isometry3d& T_a_b, const Eigen::Isometry3d& T_b_c);

/// T_b_c = T_a_b^-1 T_a_c, orthonormal. E.g. the motion between two poses in one frame.
Eigen::Isometry3d relative(const Eigen::Isometry3d& T_a_b, const Eigen::Isometry3d& T_a_c);

/// Maps perturbations (translation [m], rotation [rad]) from frame b to frame a: for small e,
/// T_a_b exp(e) = exp(adjoint(T_a_b) e) T_a_b.
Eigen::Matrix<double, 6, 6> adjoint(const Eigen::Isometry3d& T_a_b);

/// The rotation about the vector's axis by its length [rad]; identity for the zero vector.
Eigen::Matrix3d rotationBy(const Eigen::Vector3d& w_rad);

/// The cross-product matrix [v]x: v.cross(w) = skew(v) w.
Eigen::Matrix3d skew(const Eigen::Vector3d& v);

/// The constant twist (linear [m/s], angular [rad/s]) that gives this motion in dt_s, in the moving
/// frame.
Eigen::Matrix<double, 6, 1> constantTwist(const Eigen::Isometry3d& T_prev_now, double dt_s);

/// T_prev_now after dt_s with this constant twist: the inverse of constantTwist().
Eigen::Isometry3d motionOf(const Eigen::Matrix<double, 6, 1>& twist, double dt_s);

/// Rotates the axes of a camera (x right, y down, z ahead) to those of a body (x ahead, y left, z
/// up; REP 103).
inline Eigen::Matrix3d bodyFromOptical() {
  return (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
}

}  // namespace predictive_stereo
