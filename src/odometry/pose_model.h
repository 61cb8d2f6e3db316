#pragma once

#include <Eigen/Core>
#include <cmath>

#include "odometry/pose_solver.h"
#include "parallel/tasks.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {

using Matrix36d = Eigen::Matrix<double, 3, 6>;

/// T, left-multiplied by a small motion: translation [m], rotation vector [rad].
inline Eigen::Isometry3d perturbed(const Eigen::Isometry3d& T, const Vector6d& step) {
  Eigen::Isometry3d delta = Eigen::Isometry3d::Identity();
  delta.linear() = rotationBy(step.tail<3>());
  delta.translation() = step.head<3>();
  return compose(delta, T);
}

/// A correspondence as a motion predicts it.
struct PosePrediction {
  Eigen::Vector3d residual;      // current - predicted (x, y, d)
  Eigen::Vector3d by_disparity;  // derivative with respect to the previous disparity
  double x, y, inverse_depth;    // predicted: the ray (x, y, 1), and d / (f B)
  bool in_front;                 // of the camera; the others are valid only then
};

/// Predicts correspondences under a motion.
class PoseModel {
 public:
  /// The offsets are added to the disparities of the two frames.
  PoseModel(const StereoRig& rig, const Eigen::Isometry3d& T, double previous_offset_px,
            double current_offset_px)
      : rig_(rig),
        R_(T.linear()),
        t_(T.translation()),
        k_(1 / rig.disparityTimesDepth()),
        per_fx_(1 / rig.fx_px),
        per_fy_(1 / rig.fy_px),
        previous_offset_(previous_offset_px),
        current_offset_(current_offset_px) {}

  double previousDisparity(const Correspondence& c) const {
    return c.previous.z() + previous_offset_;
  }
  // Computes q = R n + t d / (f B), where n is the ray of the previous frame: the moved point
  // divided by its previous depth. This is also defined for d <= 0 (far points of a rig whose axes
  // converge).
  PosePrediction predict(const Correspondence& c) const {
    PosePrediction p;
    const double d = previousDisparity(c);
    const Eigen::Vector3d ray((c.previous.x() - rig_.cx_left_px) * per_fx_,
                              (c.previous.y() - rig_.cy_px) * per_fy_, 1);
    const Eigen::Vector3d q = R_ * ray + t_ * (d * k_);
    p.in_front = q.z() > 0.05;
    if (!p.in_front) return p;
    const double w = 1 / q.z();
    p.x = q.x() * w;
    p.y = q.y() * w;
    p.inverse_depth = d * k_ * w;
    p.residual << c.current.x() - (rig_.fx_px * p.x + rig_.cx_left_px),
        c.current.y() - (rig_.fy_px * p.y + rig_.cy_px), c.current.z() + current_offset_ - d * w;
    p.by_disparity << rig_.fx_px * (t_.x() - p.x * t_.z()) * k_ * w,
        rig_.fy_px * (t_.y() - p.y * t_.z()) * k_ * w, w - w * t_.z() * p.inverse_depth;
    return p;
  }

  // Derivative of the prediction with respect to a left-multiplied perturbation of the motion.
  Matrix36d jacobian(const PosePrediction& p) const {
    const double fx = rig_.fx_px, fy = rig_.fy_px, d = p.inverse_depth / k_;
    const double x = p.x, y = p.y;
    Matrix36d J;
    J.leftCols<3>() = p.inverse_depth * timesDepth(p);
    J.rightCols<3>() << -fx * x * y, fx * (1 + x * x), -fx * y,  //
        -fy * (1 + y * y), fy * x * y, fy * x,                   //
        -d * y, d * x, 0;
    return J;
  }
  // Derivative of jacobian()'s translation with respect to the previous disparity.
  Eigen::Matrix3d translationByDisparity(const PosePrediction& p) const {
    Eigen::Matrix3d G = timesDepth(p);
    G.row(2) *= 2;  // is itself proportional to the disparity
    return k_ * p.by_disparity.z() * G;
  }

 private:
  // The translation's part of jacobian(), times the depth.
  Eigen::Matrix3d timesDepth(const PosePrediction& p) const {
    Eigen::Matrix3d G;
    G << rig_.fx_px, 0, -rig_.fx_px * p.x,  //
        0, rig_.fy_px, -rig_.fy_px * p.y,   //
        0, 0, -p.inverse_depth / k_;
    return G;
  }

  const StereoRig& rig_;
  Eigen::Matrix3d R_;
  Eigen::Vector3d t_;
  double k_, per_fx_, per_fy_;
  double previous_offset_, current_offset_;
};

/// Information matrix of the residual: inverse of the noise of the current coordinates plus that of
/// the previous disparity propagated to them, by the matrix inversion lemma.
struct Information {
  Eigen::Vector3d diagonal, along;  // diagonal matrix minus along along^T

  Information(const Correspondence& c, const PosePrediction& p, double disparity_variance)
      : diagonal(1 / c.track_variance.x(), 1 / c.track_variance.y(), 1 / disparity_variance) {
    along = diagonal.cwiseProduct(p.by_disparity);
    along *= 1 / std::sqrt(1 / c.previous_disparity_variance + along.dot(p.by_disparity));
  }
  double squaredNorm(const Eigen::Vector3d& residual) const {
    const double projected = along.dot(residual);
    return diagonal.dot(residual.cwiseAbs2()) - projected * projected;
  }
  Eigen::Matrix3d matrix() const {
    Eigen::Matrix3d result = diagonal.asDiagonal();
    return result - along * along.transpose();
  }
};

/// Noise in the vote, and in the first iteration after it. Wide, as three noisy points give a noisy
/// motion.
class CoarseNoise {
 public:
  CoarseNoise(double expected_sigma_px, const PoseSolverParams& params)
      : gate_(2 * params.outlier_sigma * expected_sigma_px),
        jitter_(params.offset_jitter_px / expected_sigma_px) {}

  /// Inliers are within this many pixels, where the relative variance is 1.
  double gate() const { return gate_; }
  /// Of the current disparity, relative to the other variances. Before the current offset is
  /// estimated its jitter is part of the noise.
  double disparityVariance(const Correspondence& c) const {
    return c.current_disparity_variance + jitter_ * jitter_;
  }

 private:
  double gate_, jitter_;
};

}  // namespace predictive_stereo
