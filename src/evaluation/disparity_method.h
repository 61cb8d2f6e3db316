#pragma once

#include <memory>
#include <string>
#include <vector>

#include "evaluation/opencv_baseline.h"
#include "evaluation/sequence.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

/// A frame, with the odometry that all methods share.
struct MethodInput {
  int index = 0;
  StereoFrame frame;
  OdometryOutput camera;
};

struct MethodOutput {
  /// OpenCV fills only `disparity_px`, and finds no objects.
  DisparityOutput maps;
  std::vector<DetectedObject> objects;  ///< moving objects
  StageTimes times;
  double ms = 0;  ///< for the disparities, without images, ego-motion and scoring
};

/// A method that estimates disparities, frame by frame over a sequence.
class DisparityMethod {
 public:
  virtual ~DisparityMethod() = default;
  virtual void run(const MethodInput& input, MethodOutput& output) = 0;
};

/// This package with a given ego-motion; moving objects are detected and fed back.
std::unique_ptr<DisparityMethod> predictiveMethod(const PipelineParams& params);

/// OpenCV.
/// @param aligned  whether the rows of the images are aligned first, as in this package.
/// @param cache_dir  folder that keeps disparities and times for the next run on the same images;
///   empty: none. Its files are named by sequence, mode and frame.
std::unique_ptr<DisparityMethod> opencvMethod(OpencvMode mode, const DisparityParams& params,
                                              bool aligned, const std::string& cache_dir,
                                              const std::string& sequence);

}  // namespace predictive_stereo
