#pragma once

#include <memory>
#include <string>
#include <vector>

#include "evaluation/opencv_baseline.h"
#include "evaluation/sequence.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

/// A frame, and the data that several methods share.
struct MethodInput {
  int index = 0;
  StereoFrame frame;
  EgoMotionEstimate ego_motion;
};

struct MethodOutput {
  /// Of OpenCV only `disparity_px` is filled, and no objects are found.
  DisparityOutput maps;
  std::vector<DetectedObject> objects;  ///< that move
  StageTimes times;
  double ms = 0;  ///< for the disparities; images, ego-motion and scoring not included
};

/// One way to get disparities, run over a sequence frame by frame.
class DisparityMethod {
 public:
  virtual ~DisparityMethod() = default;
  virtual void run(const MethodInput& input, MethodOutput& output) = 0;
};

/// This package: the ego-motion is given, and moving objects are detected and fed back.
std::unique_ptr<DisparityMethod> predictiveMethod(const PipelineParams& params);

/// OpenCV on the images as they are, or with rows (and principal points) aligned as this package
/// does it.
/// @param cache_dir  folder that keeps the disparities and times, so that they need not be computed
///   again for the same images; empty: none. Its files are named by sequence, mode and frame.
std::unique_ptr<DisparityMethod> opencvMethod(OpencvMode mode, const DisparityParams& params,
                                              bool aligned, const std::string& cache_dir,
                                              const std::string& sequence);

}  // namespace predictive_stereo
