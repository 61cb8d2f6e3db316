#include "detection/motion_noise.h"

#include <Eigen/Cholesky>

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

bool isCovariance(const Matrix6d& matrix) {
  if (!matrix.allFinite() || !matrix.isApprox(matrix.transpose(), 1e-6)) return false;
  return Eigen::LLT<Matrix6d>(matrix).info() == Eigen::Success;
}

}  // namespace

Matrix6d toldCovariance(const Matrix6d& covariance) {
  return isCovariance(covariance) ? covariance : untoldCovariance();
}

bool isUnseen(const Matrix6d& covariance) {
  return covariance.diagonal().minCoeff() >= kUnseenVariance;
}

// A point moves by translation + rotation x point in the current frame, and is then turned.
Matrix3d pointCovariance(const Eigen::Isometry3d& T_past_cam, const Matrix6d& covariance,
                         const Vector3d& point_m) {
  Eigen::Matrix<double, 3, 6> J;
  J << T_past_cam.linear(), -T_past_cam.linear() * skew(point_m);
  return J * covariance * J.transpose();
}

PastDepthNoise::PastDepthNoise(const Eigen::Isometry3d& T_past_cam, const Matrix6d& covariance) {
  // The depth changes by v . (t + w x p) = v . t + (skew(v)^T p) . w, with v the past camera's
  // axis.
  const Vector3d v = T_past_cam.linear().row(2);
  const Matrix3d V = skew(v);
  translation_ = static_cast<float>(v.dot(covariance.topLeftCorner<3, 3>() * v));
  coupling_ = (V * covariance.bottomLeftCorner<3, 3>() * v).cast<float>();
  rotation_ = (V * covariance.bottomRightCorner<3, 3>() * V.transpose()).cast<float>();
}

}  // namespace predictive_stereo
