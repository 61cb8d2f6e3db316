#include "evaluation/disparity_method.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
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

/// Disparities in 1/16 px as 16-bit images, the time as text beside them.
class DisparityCache {
 public:
  DisparityCache(const std::string& dir, const std::string& sequence, const std::string& method) {
    if (dir.empty()) return;
    std::string name = sequence + "_" + method;
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c) && c != '_'; },
        '_');
    prefix_ = (std::filesystem::path(dir) / name).string();
    std::filesystem::create_directories(dir);
  }

  bool load(int frame, cv::Size size, cv::Mat1f& disparity_px, double& ms) const {
    std::ifstream time(file(frame, "txt"));
    if (prefix_.empty() || !(time >> ms)) return false;
    const cv::Mat coded = cv::imread(file(frame, "png"), cv::IMREAD_UNCHANGED);
    if (coded.type() != CV_16UC1 || coded.size() != size) return false;
    coded.convertTo(disparity_px, CV_32F, 1.0 / kScale, -kOffset);
    return true;
  }

  void save(int frame, const cv::Mat1f& disparity_px, double ms) const {
    if (prefix_.empty()) return;
    cv::Mat1w coded;
    disparity_px.convertTo(coded, CV_16U, kScale, kScale * kOffset);
    cv::imwrite(file(frame, "png"), coded);
    std::ofstream(file(frame, "txt")) << ms << "\n";
  }

 private:
  static constexpr int kScale = 16, kOffset = 300;

  std::string file(int frame, const char* extension) const {
    char number[16];
    std::snprintf(number, sizeof(number), "_%06d.", frame);
    return prefix_ + number + extension;
  }

  std::string prefix_;
};

class OpencvMethod : public DisparityMethod {
 public:
  OpencvMethod(OpencvMode mode, const DisparityParams& params, bool aligned,
               const std::string& cache_dir, const std::string& sequence)
      : mode_(mode),
        params_(params),
        aligned_(aligned),
        aligner_(withRowAlignment(params)),
        cache_(cache_dir, sequence,
               std::string(mode == OpencvMode::kHh ? "hh" : "3way") + (aligned ? "_aligned" : "")) {
  }

  void run(const MethodInput& input, MethodOutput& output) override {
    cv::Mat1f& disparity_px = output.maps.disparity_px;
    const StereoFrame& frame = input.frame;
    if (cache_.load(input.index, frame.left.size(), disparity_px, output.ms)) return;
    if (aligned_) {
      aligner_.begin(frame.left, frame.right, frame.rig, frame.rig);
      aligner_.matchCoarsely();
    }
    const cv::Mat1b& right = aligned_ ? aligner_.alignedRight() : frame.right;
    StageTimes times;
    Stopwatch watch;
    opencvDisparity(frame.left, right, params_.matcher.range, mode_, disparity_px,
                    frame.rig.principalOffset());
    watch.lap("OpenCV", times);
    output.ms = sum(times);
    cache_.save(input.index, disparity_px, output.ms);
  }

 private:
  OpencvMode mode_;
  DisparityParams params_;
  bool aligned_;
  DisparityEstimator aligner_;
  DisparityCache cache_;
};

}  // namespace

std::unique_ptr<DisparityMethod> predictiveMethod(const PipelineParams& params) {
  return std::make_unique<PredictiveMethod>(params);
}

std::unique_ptr<DisparityMethod> opencvMethod(OpencvMode mode, const DisparityParams& params,
                                              bool aligned, const std::string& cache_dir,
                                              const std::string& sequence) {
  return std::make_unique<OpencvMethod>(mode, params, aligned, cache_dir, sequence);
}

}  // namespace predictive_stereo
