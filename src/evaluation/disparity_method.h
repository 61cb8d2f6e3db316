#pragma once

#include <memory>
#include <optional>
#include <string>

#include "evaluation/opencv_baseline.h"
#include "evaluation/sequence.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

/// A frame with what several methods share.
struct MethodInput {
  int frame = 0;
  double stamp_s = 0;
  cv::Mat1b left, right;
  StereoRig rig;
  std::optional<CameraMotion> motion;  ///< from the previous frame, where known
};

struct MethodOutput {
  /// Of OpenCV only `disparity_px` is filled.
  DisparityOutput maps;
  StageTimes times;
  double ms = 0;  ///< for the disparities; images, ego-motion and scoring not included
};

/// One way to get disparities, run over a sequence frame by frame.
class DisparityMethod {
 public:
  virtual ~DisparityMethod() = default;
  virtual void reset() {}
  virtual void run(const MethodInput& input, MethodOutput& output) = 0;
};

/// This package: ego-motion is given, and what moves is found and fed back.
std::unique_ptr<DisparityMethod> predictiveMethod(const DisparityParams& params);

/// OpenCV on the images as they are, or with rows (and principal points) aligned as this package
/// does it.
/// @param cache_dir  folder that keeps the disparities and times, so that they need not be computed
///   again for the same images; empty: none. Its files are named by sequence, mode and frame.
std::unique_ptr<DisparityMethod> opencvMethod(OpencvMode mode, const DisparityParams& params,
                                              bool aligned, const std::string& cache_dir,
                                              const std::string& sequence);

}  // namespace predictive_stereo
