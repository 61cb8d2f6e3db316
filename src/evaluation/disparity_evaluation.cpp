#include "evaluation/disparity_evaluation.h"

#include <algorithm>
#include <cmath>

#include "tools/progress.h"

namespace predictive_stereo {
namespace {

void addTimes(const MethodOutput& output, DisparityEvaluation& evaluation) {
  updateMean(evaluation.mean_ms, output.ms, evaluation.images);
  for (const StageTime& time : output.times) {
    auto stage = std::find_if(evaluation.stage_ms.begin(), evaluation.stage_ms.end(),
                              [&](const auto& entry) { return entry.first == time.name; });
    if (stage == evaluation.stage_ms.end())
      stage = evaluation.stage_ms.insert(stage, {time.name, 0.0});
    updateMean(stage->second, time.ms, evaluation.images);
  }
}

void addWidths(const cv::Mat1w& width_px, const DisparityRange& range,
               DisparityEvaluation& evaluation) {
  if (width_px.empty()) return;
  updateMean(evaluation.mean_width_px, cv::mean(width_px)[0], evaluation.images);
  const double full = cv::countNonZero(width_px >= range.count);
  updateMean(evaluation.full_search_percent, 100 * full / static_cast<double>(width_px.total()),
             evaluation.images);
}

void addVariances(const cv::Mat1f& truth_px, const DisparityOutput& maps,
                  const DisparityRange& range, DisparityEvaluation& evaluation) {
  forEachError(maps.disparity_px, range, truth_px, [&](int x, int y, double error_px) {
    const float variance_px2 = maps.disparity_variance_px2(y, x);
    if (!(variance_px2 > 0)) {
      ++evaluation.without_variance;
      return;
    }
    evaluation.variance.add(error_px, variance_px2);
    evaluation.variance_by_disparity.add(truth_px(y, x), error_px, variance_px2);
    if (!maps.ambiguity.empty() && range.isValid(maps.measured_disparity_px(y, x)))
      evaluation.variance_by_ambiguity.add(maps.ambiguity(y, x) / 256.0, error_px, variance_px2);
  });
}

void addScores(const SequenceFrame& frame, int index, const DisparityOutput& maps,
               const DisparityRange& range, DisparityEvaluation& evaluation) {
  const DisparityScore score = scoreDisparity(maps.disparity_px, range, frame.truth_px);
  if (score.truth_pixels == 0) return;
  evaluation.score.add(score);
  for (const Region& region : frame.regions)
    evaluation.regions[region.name].add(
        scoreDisparity(maps.disparity_px, range, frame.truth_px, region.mask));
  const double width_px = maps.search_width_px.empty() ? 0.0 : cv::mean(maps.search_width_px)[0];
  evaluation.series.push_back({index, score.d1_percent(), score.d1_filled_percent(), width_px});
  if (maps.measured_disparity_px.empty()) return;

  evaluation.measured.add(scoreDisparity(maps.measured_disparity_px, range, frame.truth_px));
  cv::Mat1b common = cv::Mat1b::zeros(frame.truth_px.size());
  forEachError(maps.disparity_px, range, frame.truth_px, [&](int x, int y, double) {
    const float truth = frame.truth_px(y, x), measured = maps.measured_disparity_px(y, x);
    if (range.isValid(measured) && !isOutlier(measured, truth) &&
        !isOutlier(maps.disparity_px(y, x), truth))
      common(y, x) = 255;
  });
  evaluation.common_filtered.add(scoreDisparity(maps.disparity_px, range, frame.truth_px, common));
  evaluation.common_measured.add(
      scoreDisparity(maps.measured_disparity_px, range, frame.truth_px, common));
  addVariances(frame.truth_px, maps, range, evaluation);
}

}  // namespace

void BinnedCalibration::add(double key, double error_px, double variance_px2) {
  const double step = std::clamp(key / step_, 0.0, static_cast<double>(steps_.size() - 1));
  steps_[static_cast<size_t>(step)].add(error_px, variance_px2);
}

std::vector<BinnedCalibration::Bin> BinnedCalibration::bins(int count) const {
  int64_t total = 0;
  for (const auto& step : steps_) total += step.count();
  std::vector<Bin> bins;
  int64_t passed = 0;
  bool open = false;
  for (size_t i = 0; i < steps_.size(); ++i) {
    if (steps_[i].count() == 0) continue;
    if (!open) bins.push_back({step_ * static_cast<double>(i), 0, {}});
    bins.back().calibration += steps_[i];
    bins.back().last = step_ * static_cast<double>(i + 1);
    passed += steps_[i].count();
    open = passed * count < total * static_cast<int64_t>(bins.size());
  }
  return bins;
}

std::vector<std::unique_ptr<DisparityMethod>> startMethods(
    const std::vector<NamedMethod>& methods) {
  std::vector<std::unique_ptr<DisparityMethod>> running;
  for (const NamedMethod& method : methods) running.push_back(method.make());
  return running;
}

void evaluateDisparity(const Sequence& sequence, const std::vector<NamedMethod>& methods,
                       const PipelineParams& params, int max_frames, const FrameCallback& seen,
                       std::vector<DisparityEvaluation>& evaluations) {
  const DisparityRange& range = params.disparity.matcher.range;
  evaluations.resize(methods.size());
  const auto running = startMethods(methods);
  std::vector<MethodOutput> outputs(methods.size());
  VisualOdometry odometry(params.ego_motion, params.max_gap);

  const int frames = framesOf(sequence, max_frames);
  Progress progress(sequence.name(), frames);
  for (int index = 0; index < frames; ++index) {
    const SequenceFrame frame = sequence.frame(index);
    MethodInput input{index, stereoFrame(sequence, index, frame), {}};
    input.camera = odometry.process(input.frame);
    for (size_t m = 0; m < methods.size(); ++m) {
      running[m]->run(input, outputs[m]);
      if (seen) seen(frame, index, m, outputs[m]);
      if (index == 0) continue;  // without a past, and slower (caches and buffers are cold)
      DisparityEvaluation& evaluation = evaluations[m];
      addTimes(outputs[m], evaluation);
      addWidths(outputs[m].maps.search_width_px, range, evaluation);
      ++evaluation.images;
      if (!frame.truth_px.empty()) addScores(frame, index, outputs[m].maps, range, evaluation);
    }
    progress.update(index);
  }
}

}  // namespace predictive_stereo
