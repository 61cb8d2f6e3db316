#include "odometry/motion_vote.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

// Hypotheses that are rated in parallel. About as many are needed if most points are static.
constexpr int kBatch = 16;

struct Hypothesis {
  int chosen[3];
  Eigen::Isometry3d T;
  double cost, inlier_trust;
};

class Vote {
 public:
  Vote(const StereoRig& rig, const std::vector<Correspondence>& all, double offset_px,
       const CoarseNoise& noise)
      : rig_(rig), all_(all), offset_px_(offset_px), noise_(noise) {}

  /// Fits T to the three points; false if this is not possible.
  bool fit(Hypothesis& hypothesis) const;
  /// Sum of squared distances, each capped at the gate, weighted by trust; stops above `give_up`.
  void rate(Hypothesis& hypothesis, double give_up) const;

 private:
  const StereoRig& rig_;
  const std::vector<Correspondence>& all_;
  double offset_px_;
  const CoarseNoise& noise_;
};

// By Gauss-Newton from the expected motion.
bool Vote::fit(Hypothesis& hypothesis) const {
  const auto& chosen = hypothesis.chosen;
  if (chosen[0] == chosen[1] || chosen[1] == chosen[2] || chosen[0] == chosen[2]) return false;
  for (int iteration = 0; iteration < 6; ++iteration) {
    const PoseModel model(rig_, hypothesis.T, offset_px_, offset_px_);
    Matrix6d A = Matrix6d::Zero();
    Vector6d b = Vector6d::Zero();
    for (int i : chosen) {
      const PosePrediction p = model.predict(all_[i]);
      if (!p.in_front) return false;
      const Matrix36d J = model.jacobian(p);
      const Eigen::Matrix3d W = Information(all_[i], p, noise_.disparityVariance(all_[i])).matrix();
      const Eigen::Matrix<double, 6, 3> JtW = J.transpose() * W;
      A.noalias() += JtW * J;
      b.noalias() += JtW * p.residual;
    }
    const Vector6d step = A.ldlt().solve(b);
    if (!step.allFinite() || step.head<3>().norm() > 20 || step.tail<3>().norm() > 1) return false;
    hypothesis.T = perturbed(hypothesis.T, step);
    if (step.norm() < 1e-4) break;
  }
  return true;
}

void Vote::rate(Hypothesis& hypothesis, double give_up) const {
  const PoseModel model(rig_, hypothesis.T, offset_px_, offset_px_);
  const double cap = noise_.gate() * noise_.gate();
  hypothesis.cost = hypothesis.inlier_trust = 0;
  for (const Correspondence& c : all_) {
    const PosePrediction p = model.predict(c);
    const double m2 =
        p.in_front ? Information(c, p, noise_.disparityVariance(c)).squaredNorm(p.residual) : cap;
    if (m2 < cap) hypothesis.inlier_trust += c.trust;
    hypothesis.cost += c.trust * std::min(m2, cap);
    if (hypothesis.cost > give_up) return;
  }
}

}  // namespace

Eigen::Isometry3d voteForMotion(const StereoRig& rig,
                                const std::vector<Correspondence>& correspondences,
                                const Eigen::Isometry3d& T_expected, double offset_px,
                                const CoarseNoise& noise, int max_hypotheses) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto n = static_cast<unsigned>(correspondences.size());
  double trust_of_all = 0;
  for (const Correspondence& c : correspondences) trust_of_all += c.trust;

  const Vote vote(rig, correspondences, offset_px, noise);
  Hypothesis best{{}, T_expected, 0, 0};
  vote.rate(best, kInfinity);
  std::mt19937 random(1);
  Hypothesis batch[kBatch];
  int needed = max_hypotheses;
  for (int begin = 0; begin < needed; begin += kBatch) {
    const int count = std::min(kBatch, needed - begin);
    for (int k = 0; k < count; ++k) {
      for (int& i : batch[k].chosen) i = static_cast<int>(random() % n);
      batch[k].T = T_expected;
    }
    parallelForEach(count, [&](int k) {
      if (vote.fit(batch[k]))
        vote.rate(batch[k], best.cost);
      else
        batch[k].cost = kInfinity;
    });
    // In order: the result is that of one hypothesis after the other.
    for (int k = 0; k < count && begin + k < needed; ++k) {
      if (batch[k].cost == kInfinity) continue;
      if (batch[k].cost < best.cost) best = batch[k];
      // Four times the number of draws after which one has only static points with 99.9 %
      // probability, because three static points are noisy.
      const double share = std::clamp(best.inlier_trust / trust_of_all, 0.05, 0.95);
      needed = std::min(max_hypotheses,
                        static_cast<int>(4 * std::log(1e-3) / std::log(1 - share * share * share)));
    }
  }
  return best.T;
}

}  // namespace predictive_stereo
