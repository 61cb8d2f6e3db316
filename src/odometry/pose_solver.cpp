#include "odometry/pose_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

using Matrix36d = Eigen::Matrix<double, 3, 6>;
using Matrix38d = Eigen::Matrix<double, 3, 8>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;
using Vector8d = Eigen::Matrix<double, 8, 1>;

// Covariance of the robust estimate by that of least squares with the same weights held constant,
// for normal noise in three dimensions and the weight 1 / (1 + m^2 / 4).
constexpr double kRobustCovariance = 0.692;
// Where translation moves the points by less [px, median], what the previous offset would explain
// are the faults of the model (lenses, shutters, interpolation), not parallax: it is held.
constexpr double kSmallestParallaxPx = 1.0;
constexpr int kIterationsToHold = 2;  // until the motion is good enough to tell

Eigen::Isometry3d perturbed(const Eigen::Isometry3d& T, const Vector6d& step) {
  const Eigen::Vector3d rotation = step.tail<3>();
  const double angle = rotation.norm();
  Eigen::Isometry3d delta = Eigen::Isometry3d::Identity();
  if (angle > 0) delta.linear() = Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix();
  delta.translation() = step.head<3>();
  return compose(delta, T);
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// How a correspondence looks under a motion.
struct Prediction {
  Eigen::Vector3d residual;      // current - predicted (x, y, d)
  Eigen::Vector3d by_disparity;  // derivative of the prediction by the previous disparity
  double x, y, inverse_depth;    // predicted: the ray (x, y, 1), and d / (f B)
  bool in_front;
};

class Model {
 public:
  /// The offsets are added to the disparities of the two frames.
  Model(const StereoRig& rig, const Eigen::Isometry3d& T, double previous_offset_px,
        double current_offset_px)
      : rig_(rig),
        R_(T.linear()),
        t_(T.translation()),
        k_(1 / rig.disparityTimesDepth()),
        per_fx_(1 / rig.fx_px),
        per_fy_(1 / rig.fy_px),
        previous_offset_(previous_offset_px),
        current_offset_(current_offset_px) {}

  // Written in q = R n + t d / (f B), n being the ray of the previous frame: that is the moved
  // point divided by its previous depth, and works for d <= 0 (far points of a rig that squints) as
  // well.
  Prediction predict(const Correspondence& c) const {
    Prediction p;
    const double d = c.previous.z() + previous_offset_;
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

  // Derivative of the prediction by a left-multiplied perturbation of the motion.
  Matrix36d jacobian(const Prediction& p) const {
    const double fx = rig_.fx_px, fy = rig_.fy_px, d = p.inverse_depth / k_;
    const double x = p.x, y = p.y, z = p.inverse_depth;
    Matrix36d J;
    J << fx * z, 0, -fx * x * z, -fx * x * y, fx * (1 + x * x), -fx * y,  //
        0, fy * z, -fy * y * z, -fy * (1 + y * y), fy * x * y, fy * x,    //
        0, 0, -d * z, -d * y, d * x, 0;
    return J;
  }

 private:
  const StereoRig& rig_;
  Eigen::Matrix3d R_;
  Eigen::Vector3d t_;
  double k_, per_fx_, per_fy_;
  double previous_offset_, current_offset_;
};

// Information of the residual: the noise of the current coordinates, and that of the previous
// disparity carried over to them, by the matrix inversion lemma.
struct Information {
  Eigen::Vector3d diagonal, along;  // diagonal matrix minus along along^T

  Information(const Correspondence& c, const Prediction& p, double disparity_variance)
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

class Solver {
 public:
  Solver(const StereoRig& rig, const std::vector<Correspondence>& all,
         const DisparityOffset& previous_offset, double expected_sigma_px,
         const PoseSolverParams& params)
      : rig_(rig),
        all_(all),
        offset_(previous_offset),
        expected_sigma_(expected_sigma_px),
        coarse_gate_(2 * params.outlier_sigma * expected_sigma_px),
        params_(params) {}

  Eigen::Isometry3d vote(const Eigen::Isometry3d& T_expected) const;
  PoseSolution refine(const Eigen::Isometry3d& T_start) const;

 private:
  // While the jitter of the current offset is unknown it counts as noise of the disparities.
  double coarseVariance(const Correspondence& c) const {
    const double jitter = params_.offset_jitter_px / expected_sigma_;
    return c.current_disparity_variance + jitter * jitter;
  }
  // Derivative of the prediction, against what is measured, by all unknowns of refine().
  static Matrix38d jacobian(const Model& model, const Prediction& p) {
    Matrix38d J;
    J.leftCols<6>() = model.jacobian(p);
    J.col(6) = p.by_disparity - Eigen::Vector3d::UnitZ();
    J.col(7) = -Eigen::Vector3d::UnitZ();
    return J;
  }
  // Whether the uncertainty of the unknowns, where it exceeds that of the measurement, explains a
  // residual. Near points are sensitive to a motion that many far ones leave uncertain: they are no
  // outliers before it is known as well as they tell it.
  static bool explains(const Matrix8d& spread, const Correspondence& c, const Prediction& p,
                       const Matrix38d& J, double gate) {
    Eigen::Matrix3d noise =
        c.previous_disparity_variance * p.by_disparity * p.by_disparity.transpose();
    noise.diagonal() +=
        Eigen::Vector3d(c.track_variance.x(), c.track_variance.y(), c.current_disparity_variance);
    const Matrix38d J_spread = J * spread;
    if (J_spread.cwiseProduct(J).sum() < noise.trace()) return false;
    return p.residual.dot((noise + J_spread * J.transpose()).inverse() * p.residual) < gate * gate;
  }
  // Column and row, 0 in the image's centre and 1 at its right and its lower border.
  Eigen::RowVector2d fromCentre(const Eigen::Vector3d& point) const {
    return {2 * point.x() / rig_.size.width - 1, 2 * point.y() / rig_.size.height - 1};
  }
  bool fitThree(const int (&chosen)[3], Eigen::Isometry3d& T) const;
  double cost(const Eigen::Isometry3d& T, double give_up, double& inlier_trust) const;

  const StereoRig& rig_;
  const std::vector<Correspondence>& all_;
  const DisparityOffset offset_;
  const double expected_sigma_;
  const double coarse_gate_;  // three noisy points make a noisy motion
  const PoseSolverParams& params_;
};

// Three points determine the motion: Gauss-Newton from the expected one.
bool Solver::fitThree(const int (&chosen)[3], Eigen::Isometry3d& T) const {
  for (int iteration = 0; iteration < 6; ++iteration) {
    const Model model(rig_, T, offset_.offset_px, offset_.offset_px);
    Matrix6d A = Matrix6d::Zero();
    Vector6d b = Vector6d::Zero();
    for (int i : chosen) {
      const Prediction p = model.predict(all_[i]);
      if (!p.in_front) return false;
      const Matrix36d J = model.jacobian(p);
      const Eigen::Matrix3d W = Information(all_[i], p, coarseVariance(all_[i])).matrix();
      const Eigen::Matrix<double, 6, 3> JtW = J.transpose() * W;
      A.noalias() += JtW * J;
      b.noalias() += JtW * p.residual;
    }
    const Vector6d step = A.ldlt().solve(b);
    if (!step.allFinite() || step.head<3>().norm() > 20 || step.tail<3>().norm() > 1) return false;
    T = perturbed(T, step);
    if (step.norm() < 1e-4) break;
  }
  return true;
}

// Sum of squared distances, each capped at the gate (MSAC), weighted by trust.
double Solver::cost(const Eigen::Isometry3d& T, double give_up, double& inlier_trust) const {
  const Model model(rig_, T, offset_.offset_px, offset_.offset_px);
  const double cap = coarse_gate_ * coarse_gate_;
  double total = 0;
  inlier_trust = 0;
  for (const Correspondence& c : all_) {
    const Prediction p = model.predict(c);
    const double m2 =
        p.in_front ? Information(c, p, coarseVariance(c)).squaredNorm(p.residual) : cap;
    if (m2 < cap) inlier_trust += c.trust;
    total += c.trust * std::min(m2, cap);
    if (total > give_up) break;
  }
  return total;
}

Eigen::Isometry3d Solver::vote(const Eigen::Isometry3d& T_expected) const {
  const auto n = static_cast<unsigned>(all_.size());
  double trust_of_all = 0;
  for (const Correspondence& c : all_) trust_of_all += c.trust;

  Eigen::Isometry3d best = T_expected;
  double inlier_trust = 0, best_inlier_trust = 0;
  double best_cost = cost(best, 1e300, best_inlier_trust);
  std::mt19937 random(1);
  int needed = params_.max_hypotheses;
  for (int k = 0; k < needed; ++k) {
    int chosen[3];
    for (int& i : chosen) i = static_cast<int>(random() % n);
    if (chosen[0] == chosen[1] || chosen[1] == chosen[2] || chosen[0] == chosen[2]) continue;
    Eigen::Isometry3d T = T_expected;
    if (!fitThree(chosen, T)) continue;
    const double c = cost(T, best_cost, inlier_trust);
    if (c < best_cost) {
      best_cost = c;
      best = T;
      best_inlier_trust = inlier_trust;
    }
    // Until, with 99.9 % certainty, a draw had static points only; and then four times as many,
    // because three static points are noisy.
    const double share = std::clamp(best_inlier_trust / trust_of_all, 0.05, 0.95);
    needed = std::min(params_.max_hypotheses,
                      static_cast<int>(4 * std::log(1e-3) / std::log(1 - share * share * share)));
  }
  return best;
}

// Iteratively reweighted Gauss-Newton: every point's weight falls with its distance (Cauchy), and
// the scale of the residuals is measured on the way. Unknowns: the motion, the offset of the
// previous frame, which is held where the motion does not show it, and its change since.
PoseSolution Solver::refine(const Eigen::Isometry3d& T_start) const {
  constexpr double kFixed = 1e12;  // information of an unknown that is known
  const double jitter = params_.offset_jitter_px;
  Eigen::Vector2d prior_information(kFixed, jitter > 0 ? 1 / (jitter * jitter) : kFixed);
  bool held = true;
  const double variance_factor = kRobustCovariance * params_.common_errors;
  PoseSolution solution;
  const auto n = all_.size();
  solution.inlier.assign(n, 0);
  Eigen::Isometry3d T = T_start;
  double previous_offset = offset_.offset_px, change = 0;
  double sigma = expected_sigma_;
  double gate = coarse_gate_;
  Matrix8d A, spread;  // of the unknowns, as far as they are known after the last iteration
  std::vector<double> squared, parallax_px;
  bool tolerant = true;  // of what the uncertainty of the unknowns explains
  for (int iteration = 0; iteration < 10; ++iteration) {
    if (iteration == kIterationsToHold && offset_.variance_px2 > 0 &&
        median(parallax_px) >= kSmallestParallaxPx) {
      held = false;
      prior_information[0] = 1 / offset_.variance_px2;
    }
    parallax_px.clear();
    const Model model(rig_, T, previous_offset, previous_offset + change);
    A.setZero();
    Vector8d b = Vector8d::Zero();
    squared.clear();
    bool tolerated = false;
    for (const Correspondence& c : all_) {
      const Prediction p = model.predict(c);
      if (!p.in_front) continue;
      const Information information(
          c, p, iteration == 0 ? coarseVariance(c) : c.current_disparity_variance);
      const double m2 = information.squaredNorm(p.residual);
      if (m2 > gate * gate) {
        if (iteration == 0 || !tolerant || !explains(spread, c, p, jacobian(model, p), gate))
          continue;
        tolerated = true;
      }
      squared.push_back(m2);
      if (iteration < kIterationsToHold)
        parallax_px.push_back(p.by_disparity.head<2>().norm() *
                              std::abs(c.previous.z() + previous_offset));
      const double weight = 1 / (1 + m2 / (4 * sigma * sigma));
      const Matrix38d J = jacobian(model, p);
      const Eigen::Matrix<double, 8, 3> JtW = weight * J.transpose() * information.matrix();
      A.noalias() += JtW * J;
      b.noalias() += JtW * p.residual;
    }
    if (static_cast<int>(squared.size()) < params_.min_inliers) return solution;
    // What is known before weighs as much as the covariance, which is told below, says.
    const Eigen::Vector2d prior = variance_factor * sigma * sigma * prior_information;
    A.diagonal().tail<2>() += prior;
    b.tail<2>() +=
        prior.cwiseProduct(Eigen::Vector2d(offset_.offset_px - previous_offset, -change));
    const Eigen::LDLT<Matrix8d> factors(A);
    const Vector8d step = factors.solve(b);
    if (!step.allFinite()) return solution;
    spread = params_.common_errors * factors.solve(Matrix8d::Identity());
    T = perturbed(T, step.head<6>());
    previous_offset += step[6];
    change += step[7];
    // Median of chi-square with three degrees of freedom: 2.366.
    sigma = std::max(std::sqrt(median(squared) / 2.366), 0.1 * expected_sigma_);
    gate = std::min(coarse_gate_, std::max(params_.outlier_sigma * sigma, expected_sigma_));
    if (iteration < kIterationsToHold || step.head<3>().norm() > 1e-5 ||
        step.segment<3>(3).norm() > 1e-6)
      continue;
    // In the end the motion is known: what still disagrees with it is an outlier.
    if (!tolerated) break;
    tolerant = false;
  }

  const Model model(rig_, T, previous_offset, previous_offset + change);
  double sum = 0;
  Eigen::Matrix<double, 8, 2> by_tilt = Eigen::Matrix<double, 8, 2>::Zero();
  for (size_t i = 0; i < n; ++i) {
    const Prediction p = model.predict(all_[i]);
    if (!p.in_front) continue;
    const Information information(all_[i], p, all_[i].current_disparity_variance);
    const double m2 = information.squaredNorm(p.residual);
    if (m2 > gate * gate) continue;
    const Eigen::Matrix<double, 8, 3> JtW = jacobian(model, p).transpose() * information.matrix();
    by_tilt.noalias() += JtW / (1 + m2 / (4 * sigma * sigma)) *
                         (Eigen::Vector3d::UnitZ() * fromCentre(all_[i].current) -
                          p.by_disparity * fromCentre(all_[i].previous));
    solution.inlier[i] = 1;
    ++solution.inliers;
    sum += p.residual.squaredNorm();
  }
  if (solution.inliers < params_.min_inliers) return solution;
  const Eigen::FullPivLU<Matrix8d> lu(A);
  if (!lu.isInvertible()) return solution;
  const Matrix8d inverse = lu.inverse();
  const Matrix8d covariance = variance_factor * sigma * sigma * inverse;
  solution.found = true;
  solution.T_cam_prev = T;
  solution.sigma_px = sigma;
  solution.residual_px = std::sqrt(sum / (3 * solution.inliers));
  solution.covariance = covariance.topLeftCorner<6, 6>();
  solution.offset.offset_px = previous_offset + change;
  if (offset_.variance_px2 > 0)
    solution.by_disparity_errors.col(0) = covariance.topRightCorner<6, 2>().rowwise().sum() /
                                          std::sqrt(covariance.bottomRightCorner<2, 2>().sum());
  solution.by_disparity_errors.rightCols<2>() = inverse.topRows<6>() * by_tilt;
  if (offset_.variance_px2 > 0)
    solution.offset.variance_px2 =
        held ? offset_.variance_px2 + covariance(7, 7) : covariance.bottomRightCorner<2, 2>().sum();
  return solution;
}

}  // namespace

PoseSolution solvePose(const StereoRig& rig, const std::vector<Correspondence>& correspondences,
                       const Eigen::Isometry3d& T_expected, const DisparityOffset& previous_offset,
                       double expected_sigma_px, const PoseSolverParams& params) {
  if (static_cast<int>(correspondences.size()) < params.min_inliers) {
    PoseSolution nothing;
    nothing.inlier.assign(correspondences.size(), 0);
    return nothing;
  }
  const Solver solver(rig, correspondences, previous_offset, expected_sigma_px, params);
  return solver.refine(solver.vote(T_expected));
}

}  // namespace predictive_stereo
