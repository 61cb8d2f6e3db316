#include "evaluation/disparity_method.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

double sum(const StageTimes& times) {
  double ms = 0;
  for (const StageTime& time : times) ms += time.ms;
  return ms;
}

DetectionParams detectionParams(const DisparityRange& range) {
  DetectionParams params;
  params.range = range;
  return params;
}

class PredictiveMethod : public DisparityMethod {
 public:
  explicit PredictiveMethod(const DisparityParams& params)
      : estimator_(params), detector_(detectionParams(params.matcher.range)) {}
  void reset() override {
    estimator_.reset();
    detector_.reset();
    T_odom_cam_ = Eigen::Isometry3d::Identity();
  }
  void run(const MethodInput& input, MethodOutput& output) override {
    estimator_.prepare(input.left, input.right, input.rig);
    estimator_.estimate(input.motion, output.maps);
    output.times = estimator_.times();
    output.ms = sum(output.times);

    // What moves is no past for the next frame.
    if (input.motion) T_odom_cam_ = compose(T_odom_cam_, input.motion->T_cam_prev.inverse());
    const DisparityOutput& maps = output.maps;
    detector_.detect({input.stamp_s, input.rig, input.left, maps.measured_disparity_px,
                      maps.measured_variance_px2, maps.predicted_disparity_px,
                      maps.predicted_variance_px2, input.motion || input.frame == 0, T_odom_cam_},
                     detections_);
    estimator_.markMoving(detections_.mask);
  }

 private:
  DisparityEstimator estimator_;
  MovingObjectDetector detector_;
  Eigen::Isometry3d T_odom_cam_ = Eigen::Isometry3d::Identity();
  Detections detections_;
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
        coarse_matcher_(params.matcher),
        row_aligner_(params.row_alignment),
        cache_(cache_dir, sequence,
               std::string(mode == OpencvMode::kHh ? "hh" : "3way") + (aligned ? "_aligned" : "")) {
  }
  void reset() override { row_aligner_.reset(); }

  void run(const MethodInput& input, MethodOutput& output) override {
    cv::Mat1f& disparity_px = output.maps.disparity_px;
    if (cache_.load(input.frame, input.left.size(), disparity_px, output.ms)) return;
    const cv::Mat1b right = aligned_ ? align(input) : input.right;
    StageTimes times;
    Stopwatch watch;
    opencvDisparity(input.left, right, params_.matcher.range, mode_, disparity_px);
    watch.lap("OpenCV", times);
    output.ms = sum(times);
    cache_.save(input.frame, disparity_px, output.ms);
  }

 private:
  cv::Mat1b align(const MethodInput& input) {
    cv::Mat1b shifted, aligned;
    cv::Mat1f coarse_px;
    alignRightImage(input.right, RowOffsetModel(), input.rig.cx_left_px - input.rig.cx_right_px,
                    shifted);
    coarse_matcher_.match(input.left, shifted, coarse_px);
    alignRightImage(shifted,
                    row_aligner_.estimate(input.left, shifted, coarse_px, params_.matcher.range),
                    0.0, aligned);
    return aligned;
  }

  OpencvMode mode_;
  DisparityParams params_;
  bool aligned_;
  CoarseMatcher coarse_matcher_;
  RowAligner row_aligner_;
  DisparityCache cache_;
};

}  // namespace

std::unique_ptr<DisparityMethod> predictiveMethod(const DisparityParams& params) {
  return std::make_unique<PredictiveMethod>(params);
}

std::unique_ptr<DisparityMethod> opencvMethod(OpencvMode mode, const DisparityParams& params,
                                              bool aligned, const std::string& cache_dir,
                                              const std::string& sequence) {
  return std::make_unique<OpencvMethod>(mode, params, aligned, cache_dir, sequence);
}

}  // namespace predictive_stereo
