#include "odometry/pose_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

namespace predictive_stereo {
namespace {

using Matrix36d = Eigen::Matrix<double, 3, 6>;

// Covariance of the robust estimate by that of least squares with the same weights held constant,
// for normal noise in three dimensions and the weight 1 / (1 + m^2 / 4).
constexpr double kRobustCovariance = 0.692;

Eigen::Isometry3d perturbed(const Eigen::Isometry3d& T, const Vector6d& step) {
  const Eigen::Vector3d rotation = step.tail<3>();
  const double angle = rotation.norm();
  Eigen::Isometry3d delta = Eigen::Isometry3d::Identity();
  if (angle > 0) delta.linear() = Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix();
  delta.translation() = step.head<3>();
  return delta * T;
}

// How a correspondence looks under a motion. Written in q = R n + t d / (f B), n being the ray of
// the previous frame: that is the moved point divided by its previous depth, and works for d <= 0
// (far points of a rig that squints) as well.
struct Prediction {
  Eigen::Vector3d residual;      // current - predicted (x, y, d)
  Eigen::Vector3d by_disparity;  // derivative of the prediction by the previous disparity
  Eigen::Vector3d q;
  double inverse_depth;  // d / (f B) of the previous frame
  bool in_front;
};

class Model {
 public:
  Model(const StereoRig& rig, const Eigen::Isometry3d& T)
      : rig_(rig), R_(T.linear()), t_(T.translation()), k_(1 / rig.disparityTimesDepth()) {}

  Prediction predict(const Correspondence& c) const {
    Prediction p;
    const double d = c.previous.z();
    const Eigen::Vector3d ray((c.previous.x() - rig_.cx_left_px) / rig_.fx_px,
                              (c.previous.y() - rig_.cy_px) / rig_.fy_px, 1);
    p.inverse_depth = d * k_;
    p.q = R_ * ray + t_ * p.inverse_depth;
    p.in_front = p.q.z() > 0.05;
    if (!p.in_front) return p;
    const double w = 1 / p.q.z();
    const double x = p.q.x() * w, y = p.q.y() * w;
    p.residual << c.current.x() - (rig_.fx_px * x + rig_.cx_left_px),
        c.current.y() - (rig_.fy_px * y + rig_.cy_px), c.current.z() - d * w;
    p.by_disparity << rig_.fx_px * (t_.x() - x * t_.z()) * k_ * w,
        rig_.fy_px * (t_.y() - y * t_.z()) * k_ * w, w - d * w * w * t_.z() * k_;
    return p;
  }

  // Derivative of the prediction by a left-multiplied perturbation of the motion.
  Matrix36d jacobian(const Prediction& p) const {
    const double w = 1 / p.q.z();
    Eigen::Matrix3d by_q;
    by_q << rig_.fx_px * w, 0, -rig_.fx_px * p.q.x() * w * w,  //
        0, rig_.fy_px * w, -rig_.fy_px * p.q.y() * w * w,      //
        0, 0, -p.inverse_depth / k_ * w * w;
    Matrix36d q_by_step;
    q_by_step.leftCols<3>() = Eigen::Matrix3d::Identity() * p.inverse_depth;
    q_by_step.rightCols<3>() << 0, p.q.z(), -p.q.y(), -p.q.z(), 0, p.q.x(), p.q.y(), -p.q.x(), 0;
    return by_q * q_by_step;
  }

 private:
  const StereoRig& rig_;
  Eigen::Matrix3d R_;
  Eigen::Vector3d t_;
  double k_;
};

// Squared Mahalanobis distance of the residual, by the matrix inversion lemma.
double squaredDistance(const Correspondence& c, const Prediction& p) {
  const double ixy = 1 / c.track_variance, id = 1 / c.current_disparity_variance;
  const Eigen::Vector3d information(ixy, ixy, id);
  const Eigen::Vector3d weighted = information.cwiseProduct(p.by_disparity);
  const double along = weighted.dot(p.residual);
  const double rank_one =
      along * along / (1 / c.previous_disparity_variance + weighted.dot(p.by_disparity));
  return information.dot(p.residual.cwiseAbs2()) - rank_one;
}

Eigen::Matrix3d information(const Correspondence& c, const Prediction& p) {
  const double ixy = 1 / c.track_variance, id = 1 / c.current_disparity_variance;
  const Eigen::Vector3d diagonal(ixy, ixy, id);
  const Eigen::Vector3d weighted = diagonal.cwiseProduct(p.by_disparity);
  Eigen::Matrix3d result = diagonal.asDiagonal();
  result -= weighted * weighted.transpose() /
            (1 / c.previous_disparity_variance + weighted.dot(p.by_disparity));
  return result;
}

// Three points determine the motion; Gauss-Newton from the expected one, all noise alike.
bool fitThree(const StereoRig& rig, const std::vector<Correspondence>& all, const int (&chosen)[3],
              Eigen::Isometry3d& T) {
  for (int iteration = 0; iteration < 6; ++iteration) {
    const Model model(rig, T);
    Matrix6d A = Matrix6d::Zero();
    Vector6d b = Vector6d::Zero();
    for (int i : chosen) {
      const Prediction p = model.predict(all[i]);
      if (!p.in_front) return false;
      const Matrix36d J = model.jacobian(p);
      const Eigen::Matrix3d W = information(all[i], p);
      A.noalias() += J.transpose() * W * J;
      b.noalias() += J.transpose() * (W * p.residual);
    }
    const Eigen::LDLT<Matrix6d> ldlt(A);
    const Vector6d step = ldlt.solve(b);
    if (!step.allFinite() || step.head<3>().norm() > 20 || step.tail<3>().norm() > 1) return false;
    T = perturbed(T, step);
    if (step.norm() < 1e-4) break;
  }
  return true;
}

// Sum of squared distances, each capped at the threshold (MSAC), weighted by trust.
double cost(const StereoRig& rig, const std::vector<Correspondence>& all,
            const Eigen::Isometry3d& T, double cap, double give_up, double& inlier_trust) {
  const Model model(rig, T);
  double total = 0;
  inlier_trust = 0;
  for (const Correspondence& c : all) {
    const Prediction p = model.predict(c);
    const double m2 = p.in_front ? squaredDistance(c, p) : cap;
    if (m2 < cap) inlier_trust += c.trust;
    total += c.trust * std::min(m2, cap);
    if (total > give_up) break;
  }
  return total;
}

}  // namespace

PoseSolution solvePose(const StereoRig& rig, const std::vector<Correspondence>& all,
                       const Eigen::Isometry3d& T_expected, double expected_sigma_px,
                       const PoseSolverParams& params) {
  PoseSolution solution;
  const int n = static_cast<int>(all.size());
  solution.inlier.assign(n, 0);
  if (n < params.min_inliers) return solution;

  // Coarser than the final threshold: three noisy points make a noisy motion.
  const double coarse = 2 * params.outlier_sigma * expected_sigma_px;
  const double cap = coarse * coarse;
  double trust_of_all = 0;
  for (const Correspondence& c : all) trust_of_all += c.trust;

  double inlier_trust = 0, best_inlier_trust = 0;
  Eigen::Isometry3d best = T_expected;
  double best_cost = cost(rig, all, best, cap, 1e300, best_inlier_trust);
  std::mt19937 random(1);
  int needed = params.max_hypotheses;
  for (int k = 0; k < needed; ++k) {
    int chosen[3];
    for (int i = 0; i < 3; ++i) chosen[i] = static_cast<int>(random() % static_cast<unsigned>(n));
    if (chosen[0] == chosen[1] || chosen[1] == chosen[2] || chosen[0] == chosen[2]) continue;
    Eigen::Isometry3d T = T_expected;
    if (!fitThree(rig, all, chosen, T)) continue;
    const double c = cost(rig, all, T, cap, best_cost, inlier_trust);
    if (c < best_cost) {
      best_cost = c;
      best = T;
      best_inlier_trust = inlier_trust;
    }
    const double share = std::clamp(best_inlier_trust / trust_of_all, 0.05, 0.95);
    // With 99.9 % certainty one draw had static points only, and then three more for the noise.
    needed = std::min(params.max_hypotheses,
                      static_cast<int>(4 * std::log(1e-3) / std::log(1 - share * share * share)));
  }

  // Iteratively reweighted: every point's weight falls with its distance (Cauchy), and the scale
  // of the residuals is measured on the way.
  Eigen::Isometry3d T = best;
  double sigma = expected_sigma_px;
  double gate = coarse;
  Matrix6d A;
  std::vector<double> squared;
  for (int iteration = 0; iteration < 10; ++iteration) {
    const Model model(rig, T);
    A.setZero();
    Vector6d b = Vector6d::Zero();
    squared.clear();
    for (const Correspondence& c : all) {
      const Prediction p = model.predict(c);
      if (!p.in_front) continue;
      const double m2 = squaredDistance(c, p);
      if (m2 > gate * gate) continue;
      squared.push_back(m2);
      const double weight = 1 / (1 + m2 / (4 * sigma * sigma));
      const Matrix36d J = model.jacobian(p);
      const Eigen::Matrix3d W = weight * information(c, p);
      A.noalias() += J.transpose() * W * J;
      b.noalias() += J.transpose() * (W * p.residual);
    }
    if (static_cast<int>(squared.size()) < params.min_inliers) return solution;
    const Vector6d step = A.ldlt().solve(b);
    if (!step.allFinite()) return solution;
    T = perturbed(T, step);
    // Median of chi-square with three degrees of freedom: 2.366.
    const auto middle = squared.begin() + squared.size() / 2;
    std::nth_element(squared.begin(), middle, squared.end());
    sigma = std::max(std::sqrt(*middle / 2.366), 0.2 * expected_sigma_px);
    gate = std::min(coarse, std::max(params.outlier_sigma * sigma, 0.5 * expected_sigma_px));
    if (step.head<3>().norm() < 1e-5 && step.tail<3>().norm() < 1e-6) break;
  }

  const Model model(rig, T);
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const Prediction p = model.predict(all[i]);
    if (!p.in_front || squaredDistance(all[i], p) > gate * gate) continue;
    solution.inlier[i] = 1;
    ++solution.inliers;
    sum += p.residual.squaredNorm();
  }
  if (solution.inliers < params.min_inliers) return solution;
  const Eigen::FullPivLU<Matrix6d> lu(A);
  if (!lu.isInvertible()) return solution;
  solution.found = true;
  solution.T_cam_prev = T;
  solution.sigma_px = sigma;
  solution.residual_px = std::sqrt(sum / (3 * solution.inliers));
  solution.covariance = kRobustCovariance * sigma * sigma * lu.inverse();
  return solution;
}

}  // namespace predictive_stereo
