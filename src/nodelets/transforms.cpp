#include "nodelets/transforms.h"

#include <tf2/exceptions.h>

#include <algorithm>
#include <cmath>

namespace predictive_stereo {
namespace {

double rounded(double value) {
  constexpr double kUnit = 1.0 / 4294967296.0;  // 2^-32
  return std::round(value / kUnit) * kUnit;
}

// tf2 refuses values that are not finite, but its interpolation of huge ones can overflow.
Eigen::Isometry3d finite(const Eigen::Isometry3d& T) {
  if (!T.matrix().allFinite())
    throw tf2::InvalidArgumentException("the transform in tf is not finite: check its publisher");
  return T;
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

geometry_msgs::Pose poseMsg(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  geometry_msgs::Pose message;
  message.position.x = T.translation().x();
  message.position.y = T.translation().y();
  message.position.z = T.translation().z();
  message.orientation.x = q.x();
  message.orientation.y = q.y();
  message.orientation.z = q.z();
  message.orientation.w = q.w();
  return message;
}

geometry_msgs::Transform transformMsg(const Eigen::Isometry3d& T) {
  const geometry_msgs::Pose pose = poseMsg(T);
  geometry_msgs::Transform message;
  message.translation.x = pose.position.x;
  message.translation.y = pose.position.y;
  message.translation.z = pose.position.z;
  message.rotation = pose.orientation;
  return message;
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
  try {
    return rounded(finite(fromMsg(tf.lookupTransform(target, source, stamp).transform)));
  } catch (const tf2::TransformException& e) {
    error = e.what();
    return std::nullopt;
  }
}

std::optional<Eigen::Isometry3d> lookUpCameraMotion(const tf2::BufferCore& tf,
                                                    const std::string& camera, ros::Time previous,
                                                    ros::Time now, const std::string& fixed_frame,
                                                    std::string& error) {
  try {
    return rounded(
        finite(fromMsg(tf.lookupTransform(camera, now, camera, previous, fixed_frame).transform)));
  } catch (const tf2::TransformException& e) {
    error = e.what();
    return std::nullopt;
  }
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
