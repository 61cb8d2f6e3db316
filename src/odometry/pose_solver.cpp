#include "odometry/pose_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "odometry/motion_vote.h"
#include "odometry/pose_equations.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

// Covariance of the robust estimate / that of least squares with the same weights held constant,
// for normal noise in three dimensions and the weight 1 / (1 + m^2 / 4).
constexpr double kRobustCovariance = 0.692;
// The previous offset is held if translation moves the points by less [px, median]. Without
// parallax it would fit errors of the model (lenses, shutters, interpolation).
constexpr double kSmallestParallaxPx = 1.0;
constexpr int kIterationsToHold = 3;  // before the parallax is known well enough
// Points in a block of a sum. Blocks of fixed size: the sum does not depend on the number of
// threads.
constexpr int kBlock = 128;

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Estimate {
  Eigen::Isometry3d T;
  double previous_offset_px, change_px;  ///< of the offset since

  PoseModel model(const StereoRig& rig) const {
    return {rig, T, previous_offset_px, previous_offset_px + change_px};
  }
};

// Inliers and weights of an iteration.
struct Weighting {
  double gate;                ///< of the square root of squaredNorm()
  double sigma;               ///< a point at that distance has 80 % of the weight
  const CoarseNoise* coarse;  ///< null after the first iteration
  const Matrix8d* spread;  ///< covariance of the unknowns / sigma^2, for explains(); null: not used
};

// Whether the uncertainty of the unknowns, if it exceeds that of the measurement, explains a
// residual. Near points depend strongly on components of the motion that many far points leave
// uncertain: they must not count as outliers before these components are known.
bool explains(const Matrix8d& spread, const Correspondence& c, const PosePrediction& p,
              const Matrix38d& J, double gate) {
  Eigen::Matrix3d noise =
      c.previous_disparity_variance * p.by_disparity * p.by_disparity.transpose();
  noise.diagonal() +=
      Eigen::Vector3d(c.track_variance.x(), c.track_variance.y(), c.current_disparity_variance);
  const Matrix38d J_spread = J * spread;
  if (J_spread.cwiseProduct(J).sum() < noise.trace()) return false;
  return p.residual.dot((noise + J_spread * J.transpose()).inverse() * p.residual) < gate * gate;
}

// Where the iterations ended.
struct Fit {
  Estimate estimate;
  double sigma, gate;
  bool held = true;  ///< the previous offset is
  NormalEquations equations;
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
        coarse_(expected_sigma_px, params),
        params_(params),
        blocks_((all.size() + kBlock - 1) / kBlock) {}

  PoseSolution solve(const Eigen::Isometry3d& T_expected);

 private:
  std::optional<Fit> iterate(const Eigen::Isometry3d& T_start);
  // Takes the step that the equations ask for; false: there is none.
  bool advance(const Eigen::Vector2d& prior_information, Fit& fit, Vector8d& step,
               Matrix8d& spread) const;
  PoseSolution assess(const Fit& fit) const;
  // Sum over the inliers of how far their squared distances are below the gate of `sigma`, weighted
  // by trust.
  double support(const Estimate& estimate, double sigma) const;
  double varianceFactor() const { return kRobustCovariance * params_.common_errors; }
  void sum(const Estimate& estimate, const Weighting& weighting, NormalEquations& equations);
  void sumBlock(const PoseModel& model, const Weighting& weighting, size_t begin,
                NormalEquations& equations) const;
  // Column and row, 0 in the image's centre and 1 at its right and its lower border.
  Eigen::RowVector2d fromCentre(const Eigen::Vector3d& point) const {
    return {2 * point.x() / rig_.size.width - 1, 2 * point.y() / rig_.size.height - 1};
  }

  const StereoRig& rig_;
  const std::vector<Correspondence>& all_;
  const DisparityOffset offset_;
  const double expected_sigma_;
  const CoarseNoise coarse_;
  const PoseSolverParams& params_;
  std::vector<NormalEquations> blocks_;
};

void Solver::sumBlock(const PoseModel& model, const Weighting& weighting, size_t begin,
                      NormalEquations& equations) const {
  equations.clear();
  const double gate = weighting.gate, sigma = weighting.sigma;
  for (size_t i = begin; i < std::min(begin + kBlock, all_.size()); ++i) {
    const Correspondence& c = all_[i];
    const PosePrediction p = model.predict(c);
    if (!p.in_front) continue;
    const Information information(
        c, p,
        weighting.coarse ? weighting.coarse->disparityVariance(c) : c.current_disparity_variance);
    const double m2 = information.squaredNorm(p.residual);
    const Matrix38d J = jacobian(model, p);
    if (m2 > gate * gate) {
      if (!weighting.spread || !explains(*weighting.spread, c, p, J, gate)) continue;
      equations.excused = true;
    }
    equations.squared.push_back(m2);
    equations.parallax_px.push_back(p.by_disparity.head<2>().norm() *
                                    std::abs(model.previousDisparity(c)));
    const double weight = 1 / (1 + m2 / (4 * sigma * sigma));
    const Eigen::Matrix<double, 8, 3> JtW = weight * J.transpose() * information.matrix();
    equations.A.noalias() += JtW * J;
    equations.b.noalias() += JtW * p.residual;
  }
}

void Solver::sum(const Estimate& estimate, const Weighting& weighting, NormalEquations& equations) {
  const PoseModel model = estimate.model(rig_);
  parallelForEach(static_cast<int>(blocks_.size()), [&](int i) {
    sumBlock(model, weighting, static_cast<size_t>(i) * kBlock, blocks_[i]);
  });
  equations.clear();
  for (const NormalEquations& block : blocks_) equations.add(block);
}

// Iteratively reweighted Gauss-Newton with Cauchy weights; the scale of the residuals is estimated
// in every iteration. Unknowns: the motion; the offset of the previous frame, which is held if the
// motion does not make it observable; and its change since then.
std::optional<Fit> Solver::iterate(const Eigen::Isometry3d& T_start) {
  constexpr double kFixed = 1e12;  // information of an unknown that is known
  const double jitter = params_.offset_jitter_px;
  Eigen::Vector2d prior_information(kFixed, jitter > 0 ? 1 / (jitter * jitter) : kFixed);
  Fit fit{{T_start, offset_.offset_px, 0}, expected_sigma_, coarse_.gate(), true, {}};
  Vector8d step;
  Matrix8d spread;       // covariance of the unknowns after the last iteration
  bool tolerant = true;  // whether residuals that explains() accepts are used
  for (int iteration = 0; iteration < 10; ++iteration) {
    if (iteration == kIterationsToHold && offset_.variance_px2 > 0 &&
        median(fit.equations.parallax_px) >= kSmallestParallaxPx) {
      fit.held = false;
      prior_information[0] = 1 / offset_.variance_px2;
    }
    const bool first = iteration == 0;
    sum(fit.estimate,
        {fit.gate, fit.sigma, first ? &coarse_ : nullptr, tolerant && !first ? &spread : nullptr},
        fit.equations);
    if (static_cast<int>(fit.equations.squared.size()) < params_.min_inliers) return {};
    if (!advance(prior_information, fit, step, spread)) return {};
    if (iteration < kIterationsToHold || step.head<3>().norm() > 1e-5 ||
        step.segment<3>(3).norm() > 1e-6)
      continue;
    // After convergence the motion is known: points that still disagree are outliers.
    if (!fit.equations.excused) break;
    tolerant = false;
  }
  return fit;
}

bool Solver::advance(const Eigen::Vector2d& prior_information, Fit& fit, Vector8d& step,
                     Matrix8d& spread) const {
  auto& [estimate, sigma, gate, held, equations] = fit;
  // A is in units of the residuals; the factor converts the prior to these units.
  const Eigen::Vector2d prior = varianceFactor() * sigma * sigma * prior_information;
  equations.A.diagonal().tail<2>() += prior;
  equations.b.tail<2>() += prior.cwiseProduct(
      Eigen::Vector2d(offset_.offset_px - estimate.previous_offset_px, -estimate.change_px));
  const Eigen::LDLT<Matrix8d> factors(equations.A);
  step = factors.solve(equations.b);
  if (!step.allFinite()) return false;
  spread = params_.common_errors * factors.solve(Matrix8d::Identity());
  estimate.T = perturbed(estimate.T, step.head<6>());
  estimate.previous_offset_px += step[6];
  estimate.change_px += step[7];
  // Median of chi-square with three degrees of freedom: 2.366.
  sigma = std::max(std::sqrt(median(equations.squared) / 2.366), 0.1 * expected_sigma_);
  gate = std::min(coarse_.gate(), std::max(params_.outlier_sigma * sigma, expected_sigma_));
  return true;
}

// The inliers of a fit and its covariance.
PoseSolution Solver::assess(const Fit& fit) const {
  const auto& [estimate, sigma, gate, held, equations] = fit;
  PoseSolution solution;
  solution.inlier.assign(all_.size(), 0);
  const PoseModel model = estimate.model(rig_);
  double sum = 0;
  Eigen::Matrix<double, 8, 2> by_tilt = Eigen::Matrix<double, 8, 2>::Zero();
  DisparityNoise noise;
  for (size_t i = 0; i < all_.size(); ++i) {
    const PosePrediction p = model.predict(all_[i]);
    if (!p.in_front) continue;
    const Information information(all_[i], p, all_[i].current_disparity_variance);
    const double m2 = information.squaredNorm(p.residual);
    if (m2 > gate * gate) continue;
    const Eigen::Matrix3d W = information.matrix() / (1 + m2 / (4 * sigma * sigma));
    by_tilt.noalias() += jacobian(model, p).transpose() * W *
                         (Eigen::Vector3d::UnitZ() * fromCentre(all_[i].current) -
                          p.by_disparity * fromCentre(all_[i].previous));
    noise.add(model, p, W, sigma * sigma * all_[i].previous_disparity_variance);
    solution.inlier[i] = 1;
    ++solution.inliers;
    sum += p.residual.squaredNorm();
  }
  if (solution.inliers < params_.min_inliers) return solution;
  const std::optional<Matrix8d> spread = noise.inverse(equations.A);
  if (!spread) return solution;
  const Matrix8d covariance = varianceFactor() * sigma * sigma * *spread;
  solution.found = true;
  solution.T_cam_prev = estimate.T;
  solution.sigma_px = sigma;
  solution.residual_px = std::sqrt(sum / (3 * solution.inliers));
  solution.covariance = covariance.topLeftCorner<6, 6>();
  const Vector6d bias = spread->topLeftCorner<6, 3>() * noise.pull;
  solution.covariance += bias * bias.transpose();
  solution.offset.offset_px = estimate.previous_offset_px + estimate.change_px;
  if (offset_.variance_px2 > 0)
    solution.by_disparity_errors.col(0) = covariance.topRightCorner<6, 2>().rowwise().sum() /
                                          std::sqrt(covariance.bottomRightCorner<2, 2>().sum());
  solution.by_disparity_errors.rightCols<2>() = spread->topRows<6>() * by_tilt;
  if (offset_.variance_px2 > 0)
    solution.offset.variance_px2 =
        held ? offset_.variance_px2 + covariance(7, 7) : covariance.bottomRightCorner<2, 2>().sum();
  return solution;
}

double Solver::support(const Estimate& estimate, double sigma) const {
  const PoseModel model = estimate.model(rig_);
  const double gate = params_.outlier_sigma * sigma;
  double sum = 0;
  for (const Correspondence& c : all_) {
    const PosePrediction p = model.predict(c);
    if (!p.in_front) continue;
    const Information information(c, p, c.current_disparity_variance);
    sum += c.trust * std::max(0.0, gate * gate - information.squaredNorm(p.residual));
  }
  return sum;
}

PoseSolution Solver::solve(const Eigen::Isometry3d& T_expected) {
  PoseSolution nothing;
  nothing.inlier.assign(all_.size(), 0);
  if (static_cast<int>(all_.size()) < params_.min_inliers) return nothing;
  const std::optional<Fit> a = iterate(
      voteForMotion(rig_, all_, T_expected, offset_.offset_px, coarse_, params_.max_hypotheses));
  const std::optional<Fit> b = iterate(T_expected);
  PoseSolution voted = a ? assess(*a) : nothing, expected = b ? assess(*b) : nothing;
  if (!voted.found || !expected.found) return expected.found ? expected : voted;
  // Points that one of them explains to 0.1 px are not explained by 0.3 px.
  const double sigma = std::min(a->sigma, b->sigma);
  return support(b->estimate, sigma) / unlikeliness(expected, params_) >
                 support(a->estimate, sigma) / unlikeliness(voted, params_)
             ? expected
             : voted;
}

}  // namespace

PoseSolution solvePose(const StereoRig& rig, const std::vector<Correspondence>& correspondences,
                       const Eigen::Isometry3d& T_expected, const DisparityOffset& previous_offset,
                       double expected_sigma_px, const PoseSolverParams& params) {
  return Solver(rig, correspondences, previous_offset, expected_sigma_px, params).solve(T_expected);
}

double unlikeliness(const PoseSolution& solution, const PoseSolverParams& params) {
  constexpr double kUnlikeliness = 4;  // collisions happen, but near vehicles are more frequent
  const double sigma_m = std::sqrt(solution.covariance.topLeftCorner<3, 3>().trace());
  const Eigen::Vector3d position_m = solution.T_cam_prev.inverse().translation();
  const double away_m = (position_m - params.likely_position_m).norm();
  return away_m > params.likely_radius_m + 3 * sigma_m ? kUnlikeliness : 1;
}

}  // namespace predictive_stereo
