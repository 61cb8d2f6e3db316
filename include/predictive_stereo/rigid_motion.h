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

}  // namespace predictive_stereo
