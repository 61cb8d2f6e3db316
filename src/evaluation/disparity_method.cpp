#include "evaluation/disparity_method.h"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <utility>

namespace predictive_stereo {
namespace {

RowAlignmentParams enabled(RowAlignmentParams params) {
  params.enabled = true;
  return params;
}

class PredictiveMethod : public DisparityMethod {
 public:
  explicit PredictiveMethod(const PipelineParams& params) : pipeline_(params) {}
  void run(const MethodInput& input, MethodOutput& output) override {
    std::swap(output_.disparity, output.maps);  // reuses the memory
    pipeline_.process(
        input.frame, [&] { return input.camera; }, output_);
    std::swap(output_.disparity, output.maps);
    output.objects = output_.detections.objects;
    output.ms = 0;
    for (const StageTime& time : pipeline_.times().disparity) output.ms += time.ms;
  }
  cv::Mat1f doubt(const MethodInput&, const MethodOutput& output) override {
    return output.maps.disparity_variance_px2;
  }

 private:
  Pipeline pipeline_;
  PipelineOutput output_;
};

class OpencvMethod : public DisparityMethod {
 public:
  OpencvMethod(int mode, const DisparityParams& params, bool aligned)
      : mode_(mode),
        range_(params.matcher.range),
        aligned_(aligned),
        coarse_matcher_(params.matcher, params.min_region_px),
        row_aligner_(enabled(params.row_alignment)) {}

  void run(const MethodInput& input, MethodOutput& output) override {
    const StereoFrame& frame = input.frame;
    right_ = aligned_ ? alignedRight(frame) : frame.right;
    StageTimes times;
    Stopwatch watch;
    opencvDisparity(frame.left, right_, range_, mode_, output.maps.disparity_px,
                    frame.rig.principalOffset());
    watch.lap("OpenCV", times);
    output.ms = times.front().ms;
  }

  cv::Mat1f doubt(const MethodInput& input, const MethodOutput& output) override {
    const StereoFrame& frame = input.frame;
    const cv::Mat1f& left_px = output.maps.disparity_px;
    const double offset_px = frame.rig.principalOffset();
    // Of the mirrored pair the right image is the left one.
    cv::Mat1b left, right;
    cv::flip(right_, left, 1);
    cv::flip(frame.left, right, 1);
    cv::Mat1f right_px;
    opencvDisparity(left, right, range_, mode_, right_px, offset_px);
    cv::flip(right_px, right_px, 1);
    cv::Mat1f difference_px(left_px.size(), static_cast<float>(range_.count));
    for (int y = 0; y < left_px.rows; ++y)
      for (int x = 0; x < left_px.cols; ++x) {
        const int other = cvRound(x - left_px(y, x) - offset_px);
        if (range_.isValid(left_px(y, x)) && other >= 0 && other < left_px.cols &&
            range_.isValid(right_px(y, other)))
          difference_px(y, x) = std::abs(left_px(y, x) - right_px(y, other));
      }
    return difference_px;
  }

 private:
  cv::Mat1b alignedRight(const StereoFrame& frame) {
    const double offset_px = frame.rig.principalOffset();
    cv::Mat1f coarse_px;
    coarse_matcher_.match(frame.left, frame.right, coarse_px, offset_px);
    cv::Mat1b aligned;
    alignRightImage(frame.right,
                    row_aligner_.estimate(frame.left, frame.right, coarse_px, range_, offset_px), 0,
                    aligned);
    return aligned;
  }

  int mode_;
  DisparityRange range_;
  bool aligned_;
  CoarseMatcher coarse_matcher_;
  RowAligner row_aligner_;
  cv::Mat1b right_;
};

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

std::unique_ptr<DisparityMethod> predictiveMethod(const PipelineParams& params) {
  return std::make_unique<PredictiveMethod>(params);
}

std::unique_ptr<DisparityMethod> opencvMethod(int mode, const DisparityParams& params,
                                              bool aligned) {
  return std::make_unique<OpencvMethod>(mode, params, aligned);
}

}  // namespace predictive_stereo
