#include "evaluation/disparity_evaluation.h"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <utility>

#include "tools/progress.h"

namespace predictive_stereo {
namespace {

// Aligns the rows of right images, as this package does.
class RightAligner {
 public:
  explicit RightAligner(const DisparityParams& params)
      : range_(params.matcher.range),
        coarse_matcher_(params.matcher, params.min_region_px),
        row_aligner_(enabled(params.row_alignment)) {}

  cv::Mat1b align(const StereoFrame& frame) {
    const double offset_px = frame.rig.principalOffset();
    cv::Mat1f coarse_px;
    coarse_matcher_.match(frame.left, frame.right, coarse_px, offset_px);
    cv::Mat1b aligned;
    alignRightImage(frame.right,
                    row_aligner_.estimate(frame.left, frame.right, coarse_px, range_, offset_px), 0,
                    aligned);
    return aligned;
  }

 private:
  static RowAlignmentParams enabled(RowAlignmentParams params) {
    params.enabled = true;
    return params;
  }

  DisparityRange range_;
  CoarseMatcher coarse_matcher_;
  RowAligner row_aligner_;
};

// See MethodOutput::doubt.
// @param left_px  disparities of OpenCV from these images.
cv::Mat1f leftRightDifference(const cv::Mat1b& left, const cv::Mat1b& right, double offset_px,
                              const DisparityRange& range, int mode, const cv::Mat1f& left_px) {
  // Of the mirrored pair the right image is the left one.
  cv::Mat1b mirrored_left, mirrored_right;
  cv::flip(right, mirrored_left, 1);
  cv::flip(left, mirrored_right, 1);
  cv::Mat1f right_px;
  opencvDisparity(mirrored_left, mirrored_right, range, mode, right_px, offset_px);
  cv::flip(right_px, right_px, 1);
  cv::Mat1f difference_px(left_px.size(), static_cast<float>(range.count));
  for (int y = 0; y < left_px.rows; ++y)
    for (int x = 0; x < left_px.cols; ++x) {
      const int other = cvRound(x - left_px(y, x) - offset_px);
      if (range.isValid(left_px(y, x)) && other >= 0 && other < left_px.cols &&
          range.isValid(right_px(y, other)))
        difference_px(y, x) = std::abs(left_px(y, x) - right_px(y, other));
    }
  return difference_px;
}

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

void opencvDisparity(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityRange& range,
                     int mode, cv::Mat1f& disparity_px, double principal_offset_px) {
  constexpr int kBlock = 3, kP1 = 26, kP2 = 470;
  const int first = range.min_disparity + cvFloor(principal_offset_px);
  const auto matcher = cv::StereoSGBM::create(first, range.count, kBlock, kP1, kP2);
  matcher->setMode(mode);
  cv::Mat1s fixed_point;
  matcher->compute(left, right, fixed_point);
  fixed_point.convertTo(disparity_px, CV_32F, 1.0 / cv::StereoMatcher::DISP_SCALE,
                        -principal_offset_px);
  if (principal_offset_px == 0) return;
  const cv::Mat1b unknown = fixed_point < first * cv::StereoMatcher::DISP_SCALE;
  cv::max(disparity_px, static_cast<double>(range.min_disparity), disparity_px);
  disparity_px.setTo(range.invalid(), unknown);
}

DisparityMethod predictiveMethod(const PipelineParams& params) {
  const auto pipeline = std::make_shared<Pipeline>(params);
  const auto buffer = std::make_shared<PipelineOutput>();
  return [=](const MethodInput& input, MethodOutput& output) {
    std::swap(buffer->disparity, output.maps);  // reuses the memory
    pipeline->process(
        input.frame, [&] { return input.camera; }, *buffer);
    std::swap(buffer->disparity, output.maps);
    output.objects = buffer->detections.objects;
    output.ms = 0;
    for (const StageTime& time : pipeline->times().disparity) output.ms += time.ms;
  };
}

DisparityMethod opencvMethod(int mode, const DisparityParams& params, bool aligned) {
  const auto aligner = aligned ? std::make_shared<RightAligner>(params) : nullptr;
  return [=, range = params.matcher.range](const MethodInput& input, MethodOutput& output) {
    const StereoFrame& frame = input.frame;
    const cv::Mat1b left = frame.left, right = aligner ? aligner->align(frame) : frame.right;
    const double offset_px = frame.rig.principalOffset();
    StageTimes times;
    Stopwatch watch;
    opencvDisparity(left, right, range, mode, output.maps.disparity_px, offset_px);
    watch.lap("OpenCV", times);
    output.ms = times.front().ms;
    output.doubt = [=, left_px = output.maps.disparity_px] {
      return leftRightDifference(left, right, offset_px, range, mode, left_px);
    };
  };
}

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
