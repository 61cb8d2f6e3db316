/// Normal equations of the motion and of the offset of the disparities.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <optional>
#include <vector>

#include "odometry/pose_model.h"

namespace predictive_stereo {

/// Unknowns: the motion, the offset of the previous frame's disparities, its change since.
using Matrix38d = Eigen::Matrix<double, 3, 8>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;
using Vector8d = Eigen::Matrix<double, 8, 1>;

/// A step = b, summed over points.
struct NormalEquations {
  Matrix8d A = Matrix8d::Zero();
  Vector8d b = Vector8d::Zero();
  std::vector<double> squared;      ///< squared distances of the inliers
  std::vector<double> parallax_px;  ///< of the inliers
  bool excused = false;  ///< whether some are inliers only by the uncertainty of the unknowns

  void clear() {
    A.setZero();
    b.setZero();
    squared.clear();
    parallax_px.clear();
    excused = false;
  }
  void add(const NormalEquations& other) {
    A += other.A;
    b += other.b;
    squared.insert(squared.end(), other.squared.begin(), other.squared.end());
    parallax_px.insert(parallax_px.end(), other.parallax_px.begin(), other.parallax_px.end());
    excused = excused || other.excused;
  }
};

/// Derivative of prediction - measurement with respect to all unknowns.
inline Matrix38d jacobian(const PoseModel& model, const PosePrediction& p) {
  Matrix38d J;
  J.leftCols<6>() = model.jacobian(p);
  J.col(6) = p.by_disparity - Eigen::Vector3d::UnitZ();
  J.col(7) = -Eigen::Vector3d::UnitZ();
  return J;
}

/// What noise of the previous disparities does to the equations, as the translation's derivatives
/// are proportional to these disparities.
struct DisparityNoise {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< in A, but of noise only
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();         ///< in b, mostly towards no translation

  /// A point with its weight, and the variance [px^2] of its previous disparity.
  void add(const PoseModel& model, const PosePrediction& p, const Eigen::Matrix3d& weight,
           double variance_px2) {
    const Eigen::Matrix3d G = model.translationByDisparity(p);
    const Eigen::Matrix3d GtW = variance_px2 * G.transpose() * weight;
    information.noalias() += GtW * G;
    pull.noalias() += GtW * p.by_disparity;
  }
  /// Inverse of A without it. None if little else says anything about the translation in some
  /// direction: far points alone would be certain that the camera stands.
  std::optional<Matrix8d> inverse(Matrix8d A) const {
    constexpr double kMargin = 0.5;  // of the remainder, as the noise is known only on average
    A.topLeftCorner<3, 3>() -= (1 + kMargin) * information;
    if (Eigen::LLT<Matrix8d>(A).info() != Eigen::Success) return {};
    A.topLeftCorner<3, 3>() += kMargin * information;
    const Eigen::FullPivLU<Matrix8d> factors(A);
    if (!factors.isInvertible()) return {};
    return factors.inverse();
  }
};

}  // namespace predictive_stereo
