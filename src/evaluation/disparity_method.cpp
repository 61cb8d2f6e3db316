#include "evaluation/disparity_method.h"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <utility>

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

}  // namespace predictive_stereo
