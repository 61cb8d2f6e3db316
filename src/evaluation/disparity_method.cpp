#include "evaluation/disparity_method.h"

#include <opencv2/calib3d.hpp>
#include <utility>

namespace predictive_stereo {
namespace {

double sum(const StageTimes& times) {
  double ms = 0;
  for (const StageTime& time : times) ms += time.ms;
  return ms;
}

DisparityParams withRowAlignment(DisparityParams params) {
  params.row_alignment.enabled = true;
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
    output.times = pipeline_.times().disparity;
    output.ms = sum(output.times);
  }

 private:
  Pipeline pipeline_;
  PipelineOutput output_;
};

class OpencvMethod : public DisparityMethod {
 public:
  OpencvMethod(OpencvMode mode, const DisparityParams& params, bool aligned)
      : mode_(mode), params_(params), aligned_(aligned), aligner_(withRowAlignment(params)) {}

  void run(const MethodInput& input, MethodOutput& output) override {
    const StereoFrame& frame = input.frame;
    if (aligned_) {
      aligner_.begin(frame.left, frame.right, frame.rig, frame.rig);
      aligner_.matchCoarsely();
    }
    const cv::Mat1b& right = aligned_ ? aligner_.alignedRight() : frame.right;
    StageTimes times;
    Stopwatch watch;
    opencvDisparity(frame.left, right, params_.matcher.range, mode_, output.maps.disparity_px,
                    frame.rig.principalOffset());
    watch.lap("OpenCV", times);
    output.ms = sum(times);
  }

 private:
  OpencvMode mode_;
  DisparityParams params_;
  bool aligned_;
  DisparityEstimator aligner_;
};

}  // namespace

void opencvDisparity(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityRange& range,
                     OpencvMode mode, cv::Mat1f& disparity_px, double principal_offset_px) {
  constexpr int kBlock = 3, kP1 = 26, kP2 = 470;
  const int first = range.min_disparity + cvFloor(principal_offset_px);
  const auto matcher = cv::StereoSGBM::create(first, range.count, kBlock, kP1, kP2);
  matcher->setMode(mode == OpencvMode::kHh ? cv::StereoSGBM::MODE_HH
                                           : cv::StereoSGBM::MODE_SGBM_3WAY);
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

std::unique_ptr<DisparityMethod> opencvMethod(OpencvMode mode, const DisparityParams& params,
                                              bool aligned) {
  return std::make_unique<OpencvMethod>(mode, params, aligned);
}

}  // namespace predictive_stereo
