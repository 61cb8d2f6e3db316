#include "evaluation/disparity_evaluation.h"

#include "tools/progress.h"

namespace predictive_stereo {
namespace {

void addScores(const SequenceFrame& frame, int index, const DisparityOutput& maps,
               const DisparityRange& range, DisparityEvaluation& evaluation) {
  const DisparityScore score = scoreDisparity(maps.disparity_px, range, frame.truth_px);
  if (score.truth_pixels == 0) return;
  evaluation.score.add(score);
  const double width_px = maps.search_width_px.empty() ? 0.0 : cv::mean(maps.search_width_px)[0];
  evaluation.series.push_back({index, score.d1_percent(), score.d1_filled_percent(), width_px});
  if (maps.measured_disparity_px.empty()) return;

  evaluation.measured.add(scoreDisparity(maps.measured_disparity_px, range, frame.truth_px));
  forEachError(maps.disparity_px, range, frame.truth_px, [&](int x, int y, double error_px) {
    evaluation.variance.add(error_px, maps.disparity_variance_px2(y, x));
  });
}

}  // namespace

std::vector<DisparityMethod> startMethods(const std::vector<NamedMethod>& methods) {
  std::vector<DisparityMethod> running;
  for (const NamedMethod& method : methods) running.push_back(method.make());
  return running;
}

void evaluateDisparity(const Sequence& sequence, const std::vector<NamedMethod>& methods,
                       const PipelineParams& params, int max_frames, const FrameCallback& seen,
                       std::vector<DisparityEvaluation>& evaluations) {
  const DisparityRange& range = params.disparity.matcher.range;
  evaluations.resize(methods.size());
  for (size_t m = 0; m < methods.size(); ++m) evaluations[m].method = methods[m].name;
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
      running[m](input, outputs[m]);
      if (seen) seen(frame, index, m, outputs[m]);
      if (index == 0) continue;  // without a past, and slower (caches and buffers are cold)
      DisparityEvaluation& evaluation = evaluations[m];
      updateMean(evaluation.mean_ms, outputs[m].ms, evaluation.images);
      const cv::Mat1w& width_px = outputs[m].maps.search_width_px;
      if (!width_px.empty())
        updateMean(evaluation.mean_width_px, cv::mean(width_px)[0], evaluation.images);
      ++evaluation.images;
      if (!frame.truth_px.empty()) addScores(frame, index, outputs[m].maps, range, evaluation);
    }
    progress.update(index);
  }
}

}  // namespace predictive_stereo
