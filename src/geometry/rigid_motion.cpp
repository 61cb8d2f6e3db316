#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {

Eigen::Isometry3d orthonormal(const Eigen::Isometry3d& T) {
  Eigen::Isometry3d result = T;
  result.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  return result;
}

Eigen::Isometry3d compose(const Eigen::Isometry3d& T_a_b, const Eigen::Isometry3d& T_b_c) {
  return orthonormal(T_a_b * T_b_c);
}

Eigen::Isometry3d relative(const Eigen::Isometry3d& T_a_b, const Eigen::Isometry3d& T_a_c) {
  return orthonormal(T_a_b.inverse() * T_a_c);
}

}  // namespace predictive_stereo
