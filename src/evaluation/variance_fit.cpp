#include "evaluation/variance_fit.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <opencv2/core/optim.hpp>
#include <random>
#include <utility>

namespace predictive_stereo {
namespace {

constexpr double kOneSigma = 0.6827, kTwoSigma = 0.9545;
constexpr size_t kMinSamples = 200;

double matchSigma(const VarianceSample& sample, const VarianceParams& params) {
  const double t =
      std::max(0.0, (sample.ambiguity - params.ambiguity_onset) / (1.0 - params.ambiguity_onset));
  return params.sigma_floor_px + params.sigma_ambiguous_px * t * t;
}

/// The part of the variance that is the same for measured, kept and filled disparities.
double commonVariance(const VarianceSample& sample, const VarianceParams& params) {
  const double ambiguity = sample.measured ? sample.ambiguity : 1;
  const double doubt = 1 + params.ambiguity_weight * ambiguity * ambiguity +
                       (sample.measured && !sample.predicted ? params.unpredicted_weight : 0);
  const double around_px = params.sigma_disagreement_px * sample.disagreement * doubt;
  const double far_px = rectificationShare(sample.row_offset_px) * params.sigma_far_px /
                        (1 + std::max(sample.disparity_px, 0.0f) / kFarDisparityPx);
  const double rig_px = params.sigma_per_row_offset * sample.row_offset_px * sample.disparity_px;
  return around_px * around_px + far_px * far_px + rig_px * rig_px;
}

/// The part of a match's variance that depends on the prediction, or its absence.
double innovationVariance(const VarianceSample& sample, const VarianceParams& params) {
  if (!sample.predicted) {
    const double unpredicted_px =
        rectificationShare(sample.row_offset_px) * params.sigma_unpredicted_px;
    return unpredicted_px * unpredicted_px;
  }
  const double innovation_px = std::min<double>(sample.innovation_px, params.max_innovation_px);
  return params.innovation_weight * innovation_px * innovation_px;
}

/// Loss of quantile regression for sigma as the 68.3 % and 2 sigma as the 95.4 % quantile of
/// |error|. It uses logarithms, which have the same quantiles: all pixels then have the same
/// weight, as for the shares of errors within 1 and 2 sigma. Without logarithms large errors would
/// dominate.
double quantileLoss(double error_px, double sigma_px) {
  constexpr double kFinestError_px = 0.01;
  const double beyond = std::log(std::max(std::abs(error_px), kFinestError_px) / sigma_px);
  const auto loss = [](double log_ratio, double share) {
    return log_ratio > 0 ? share * log_ratio : (share - 1) * log_ratio;
  };
  return loss(beyond, kOneSigma) + loss(beyond - std::log(2.0), kTwoSigma);
}

/// An error and the known part of its variance.
struct KnownPart {
  double error_px, variance_px2;
};

/// The s for which sigma = sqrt(known variance + s^2) has the smallest loss.
double addedSigma(const std::vector<KnownPart>& samples, double otherwise) {
  if (samples.size() < kMinSamples) return otherwise;
  double best = otherwise, least = std::numeric_limits<double>::infinity();
  for (double s = 0.01; s < 10; s *= 1.04) {
    double loss = 0;
    for (const KnownPart& sample : samples)
      loss += quantileLoss(sample.error_px, std::sqrt(sample.variance_px2 + s * s));
    if (loss < least) {
      least = loss;
      best = s;
    }
  }
  return best;
}

/// A random choice of samples for which `keep` holds: the same number from each set, at most
/// `count`.
std::vector<VarianceSample> chooseSamples(const std::vector<std::vector<VarianceSample>>& sets,
                                          size_t count, bool (*keep)(const VarianceSample&)) {
  std::vector<std::vector<VarianceSample>> kept(sets.size());
  for (size_t i = 0; i < sets.size(); ++i) {
    std::copy_if(sets[i].begin(), sets[i].end(), std::back_inserter(kept[i]), keep);
    if (!kept[i].empty()) count = std::min(count, kept[i].size());
  }
  std::vector<VarianceSample> chosen;
  std::mt19937 random(1);
  for (auto& samples : kept) {
    if (samples.empty()) continue;
    // Not std::shuffle: its result depends on the standard library.
    for (size_t i = 0; i < count; ++i) {
      std::swap(samples[i], samples[i + random() % (samples.size() - i)]);
      chosen.push_back(samples[i]);
    }
  }
  return chosen;
}

// The parameters of measured disparities, which are fitted together.
struct FittedParam {
  double VarianceParams::*value;
  double step;       // of the solver, at first
  double low, high;  // limits
  double unit = 1;   // the solver sees multiples of 1 / unit
};
constexpr FittedParam kFitted[] = {
    {&VarianceParams::sigma_floor_px, 0.1, 0.05, 10},
    {&VarianceParams::sigma_ambiguous_px, 0.3, 0, 100},
    {&VarianceParams::ambiguity_onset, 0.1, 0, 0.9},
    {&VarianceParams::innovation_weight, 0.1, 0, 1},
    {&VarianceParams::sigma_disagreement_px, 0.2, 0, 100},
    {&VarianceParams::sigma_per_row_offset, 0.5, 0, 100, 100},
    {&VarianceParams::sigma_far_px, 0.2, 0, 100},
    {&VarianceParams::sigma_unpredicted_px, 0.2, 0, 100},
    {&VarianceParams::ambiguity_weight, 1.0, 0, 100},
    {&VarianceParams::unpredicted_weight, 0.5, 0, 100},
};
constexpr int kDims = std::size(kFitted);

/// Mean loss as a function of kFitted.
class MatchLoss : public cv::MinProblemSolver::Function {
 public:
  MatchLoss(std::vector<VarianceSample> samples, const VarianceParams& start)
      : samples_(std::move(samples)), start_(start) {}
  int getDims() const override { return kDims; }
  double calc(const double* x) const override {
    // The solver has no bounds: the loss grows outside the limits.
    double penalty = 0;
    VarianceParams params = start_;
    for (int i = 0; i < kDims; ++i) {
      const double inside = std::clamp(x[i], kFitted[i].low, kFitted[i].high);
      penalty += std::abs(x[i] - inside);
      params.*kFitted[i].value = inside / kFitted[i].unit;
    }
    double loss = 0;
    for (const VarianceSample& sample : samples_) {
      const double match_px = matchSigma(sample, params);
      loss += quantileLoss(sample.error_px,
                           std::sqrt(match_px * match_px + innovationVariance(sample, params) +
                                     commonVariance(sample, params)));
    }
    return loss / static_cast<double>(samples_.size()) + penalty;
  }

 private:
  std::vector<VarianceSample> samples_;
  VarianceParams start_;
};

bool isMeasured(const VarianceSample& s) { return s.measured; }
bool isPredicted(const VarianceSample& s) { return s.predicted; }
bool isKept(const VarianceSample& s) { return !s.measured && s.predicted; }
bool isFilled(const VarianceSample& s) { return !s.measured && !s.predicted; }

double rounded(double value) {
  if (value < 1e-6) return 0;
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  return std::round(value / unit) * unit;
}

// Parameters that no sample depends on keep their values.
VarianceParams fitMeasured(std::vector<VarianceSample> measured, const VarianceParams& start) {
  const auto with_past =
      static_cast<size_t>(std::count_if(measured.begin(), measured.end(), isPredicted));
  const bool few_with = with_past < kMinSamples,
             few_without = measured.size() - with_past < kMinSamples;
  cv::Mat1d x(1, kDims), steps(1, kDims);
  for (int i = 0; i < kDims; ++i) {
    x(i) = kFitted[i].unit * start.*kFitted[i].value;
    steps(i) = kFitted[i].step;
  }
  const auto solver = cv::DownhillSolver::create(
      cv::makePtr<MatchLoss>(std::move(measured), start), steps,
      cv::TermCriteria(cv::TermCriteria::MAX_ITER + cv::TermCriteria::EPS, 1200, 1e-7));
  solver->minimize(x);
  VarianceParams fitted = start;
  for (int i = 0; i < kDims; ++i)
    fitted.*kFitted[i].value =
        rounded(std::clamp(x(i), kFitted[i].low, kFitted[i].high) / kFitted[i].unit);
  if (few_with) fitted.innovation_weight = start.innovation_weight;
  if (few_without) fitted.sigma_unpredicted_px = start.sigma_unpredicted_px;
  if (few_with || few_without) fitted.unpredicted_weight = start.unpredicted_weight;
  return fitted;
}

}  // namespace

VarianceParams fitVariance(const std::vector<std::vector<VarianceSample>>& sets,
                           const VarianceParams& start) {
  constexpr size_t kSamples = 60000;
  VarianceParams fitted = start;
  std::vector<VarianceSample> measured = chooseSamples(sets, kSamples, isMeasured);
  if (measured.size() >= kMinSamples) fitted = fitMeasured(std::move(measured), start);
  const auto beyondCommon = [&](bool (*kind)(const VarianceSample&)) {
    std::vector<KnownPart> parts;
    for (const VarianceSample& sample : chooseSamples(sets, kSamples, kind))
      parts.push_back({sample.error_px, commonVariance(sample, fitted)});
    return parts;
  };
  fitted.sigma_kept_px = rounded(addedSigma(beyondCommon(isKept), start.sigma_kept_px));
  fitted.sigma_filled_px = rounded(addedSigma(beyondCommon(isFilled), start.sigma_filled_px));
  return fitted;
}

}  // namespace predictive_stereo
