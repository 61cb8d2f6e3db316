#include "predictive_stereo/rigid_motion.h"

#include <cmath>

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

Eigen::Matrix3d rotationBy(const Eigen::Vector3d& w_rad) {
  const double angle_rad = w_rad.norm();
  if (angle_rad == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle_rad, w_rad / angle_rad).toRotationMatrix();
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

Eigen::Matrix<double, 6, 1> constantTwist(const Eigen::Isometry3d& T_prev_now, double dt_s) {
  const Eigen::AngleAxisd rotation(T_prev_now.linear());
  const Eigen::Vector3d w = rotation.angle() * rotation.axis();
  const double angle = w.norm();
  // Inverse of the left Jacobian of SE(3)'s exponential; a series for small angles.
  const double c =
      angle > 1e-3 ? (1 - angle * std::sin(angle) / (2 * (1 - std::cos(angle)))) / (angle * angle)
                   : 1.0 / 12;
  const Eigen::Matrix3d W = skew(w);
  const Eigen::Matrix3d V_inverse = Eigen::Matrix3d::Identity() - 0.5 * W + c * W * W;
  Eigen::Matrix<double, 6, 1> twist;
  twist << V_inverse * T_prev_now.translation(), w;
  return twist / dt_s;
}

Eigen::Isometry3d motionOf(const Eigen::Matrix<double, 6, 1>& twist, double dt_s) {
  const Eigen::Vector3d v = dt_s * twist.head<3>(), w = dt_s * twist.tail<3>();
  const double angle = w.norm();
  // The left Jacobian of SE(3)'s exponential; a series for small angles.
  const double b = angle > 1e-4 ? (1 - std::cos(angle)) / (angle * angle) : 0.5;
  const double c = angle > 1e-4 ? (angle - std::sin(angle)) / (angle * angle * angle) : 1.0 / 6;
  const Eigen::Matrix3d W = skew(w);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotationBy(w);
  T.translation() = v + b * W * v + c * W * W * v;
  return T;
}

}  // namespace predictive_stereo
