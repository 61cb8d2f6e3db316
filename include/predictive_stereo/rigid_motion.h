/// Products of rigid motions whose rotations stay rotations.
#pragma once

#include <Eigen/Geometry>

namespace predictive_stereo {

/// T with the rotation nearest to its linear part, which must nearly be one.
///
/// Isometry3d::inverse() transposes. In a feedback such as A <- A B, B <- A C^-1 the deviation from
/// a rotation therefore grows by a factor each time, from rounding errors to visible in 34 frames.
Eigen::Isometry3d orthonormal(const Eigen::Isometry3d& T);

/// T_a_c = T_a_b T_b_c. To be used wherever a product is kept, to be multiplied again.
Eigen::Isometry3d compose(const Eigen::Isometry3d& T_a_b, const Eigen::Isometry3d& T_b_c);

/// T_b_c = T_a_b^-1 T_a_c, e.g. the motion between two poses in one frame.
Eigen::Isometry3d relative(const Eigen::Isometry3d& T_a_b, const Eigen::Isometry3d& T_a_c);

/// Takes perturbations (translation, rotation) from frame b to frame a: for small e,
/// T_a_b exp(e) = exp(adjoint(T_a_b) e) T_a_b.
Eigen::Matrix<double, 6, 6> adjoint(const Eigen::Isometry3d& T_a_b);

/// [v]x: v.cross(w) = skew(v) w.
Eigen::Matrix3d skew(const Eigen::Vector3d& v);

}  // namespace predictive_stereo
