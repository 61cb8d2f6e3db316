#include "nodelets/transforms.h"

#include <tf2/exceptions.h>
#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <cmath>

namespace predictive_stereo {
namespace {

double rounded(double value) {
  constexpr double kUnit = 1.0 / 4294967296.0;  // 2^-32
  return std::round(value / kUnit) * kUnit;
}

Eigen::Isometry3d rounded(const Eigen::Isometry3d& T) {
  Eigen::Quaterniond q(T.linear());
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  q.coeffs() = q.coeffs().unaryExpr([](double c) { return rounded(c); });
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = q.normalized().toRotationMatrix();
  result.translation() = T.translation().unaryExpr([](double c) { return rounded(c); });
  return result;
}

// What `look_up` finds in tf, rounded.
template <class LookUp>
std::optional<Eigen::Isometry3d> found(const LookUp& look_up, std::string& error) {
  try {
    const Eigen::Isometry3d T = fromMsg(look_up().transform);
    if (T.matrix().allFinite()) return rounded(T);
    // tf2 refuses values that are not finite, but its interpolation of huge ones can overflow.
    error = "the transform in tf is not finite: check its publisher";
  } catch (const tf2::TransformException& e) {
    error = e.what();
  }
  return std::nullopt;
}

}  // namespace

Eigen::Isometry3d fromMsg(const geometry_msgs::Transform& message) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(message.rotation.w, message.rotation.x, message.rotation.y,
                                  message.rotation.z)
                   .normalized()
                   .toRotationMatrix();
  T.translation() << message.translation.x, message.translation.y, message.translation.z;
  return T;
}

geometry_msgs::Transform transformMsg(const Eigen::Isometry3d& T) {
  return tf2::eigenToTransform(T).transform;
}

Matrix6d fromMsg(const boost::array<double, 36>& covariance) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(covariance.data());
}

boost::array<double, 36> covarianceMsg(const Matrix6d& covariance) {
  boost::array<double, 36> message;
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message.data()) = covariance;
  return message;
}

std::optional<Eigen::Isometry3d> lookUpTransform(const tf2::BufferCore& tf,
                                                 const std::string& target,
                                                 const std::string& source, ros::Time stamp,
                                                 std::string& error) {
  return found([&] { return tf.lookupTransform(target, source, stamp); }, error);
}

std::optional<Eigen::Isometry3d> lookUpCameraMotion(const tf2::BufferCore& tf,
                                                    const std::string& camera, ros::Time previous,
                                                    ros::Time now, const std::string& fixed_frame,
                                                    std::string& error) {
  return found([&] { return tf.lookupTransform(camera, now, camera, previous, fixed_frame); },
               error);
}

bool twistIsUnknown(const nav_msgs::Odometry& odometry) {
  return fromMsg(odometry.twist.covariance).diagonal().minCoeff() >= kUnknownCovariance;
}

Matrix6d motionCovariance(const nav_msgs::Odometry& odometry, double dt_s,
                          const Eigen::Isometry3d& T_cam_child) {
  const Matrix6d twist = fromMsg(odometry.twist.covariance);
  const Vector6d variances = twist.diagonal();
  // Wheel odometry has huge variances for axes that it does not measure.
  if (!twist.allFinite() || variances.minCoeff() < 0 || variances.maxCoeff() >= kUnknownCovariance)
    return Matrix6d::Zero();
  const Matrix6d A = adjoint(T_cam_child);
  return A * twist * A.transpose() * (dt_s * dt_s);
}

}  // namespace predictive_stereo
