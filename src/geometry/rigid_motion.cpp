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

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix<double, 6, 6> adjoint(const Eigen::Isometry3d& T_a_b) {
  Eigen::Matrix<double, 6, 6> result = Eigen::Matrix<double, 6, 6>::Zero();
  result.topLeftCorner<3, 3>() = T_a_b.linear();
  result.topRightCorner<3, 3>() = skew(T_a_b.translation()) * T_a_b.linear();
  result.bottomRightCorner<3, 3>() = T_a_b.linear();
  return result;
}

}  // namespace predictive_stereo
