#pragma once

#include <memory>
#include <vector>

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
  double ms = 0;  ///< for the disparities, without images, ego-motion and scoring
};

/// A method that estimates disparities, frame by frame over a sequence.
class DisparityMethod {
 public:
  virtual ~DisparityMethod() = default;
  virtual void run(const MethodInput& input, MethodOutput& output) = 0;
  /// Orders the pixels of run()'s result by their certainty: the larger, the less certain. Ours:
  /// the variance. OpenCV: the difference between left and right disparities [px], from a second
  /// match of the right image; the number of disparities where the right image has none.
  /// Empty: not known.
  virtual cv::Mat1f doubt(const MethodInput& /*input*/, const MethodOutput& /*output*/) {
    return {};
  }
};

/// This package with a given ego-motion; moving objects are detected and fed back.
std::unique_ptr<DisparityMethod> predictiveMethod(const PipelineParams& params);

/// OpenCV's semi-global matching with the paper's parameters (P1 26, P2 470, block 3; OpenCV's
/// defaults for all others).
/// @param mode  of cv::StereoSGBM: MODE_HH, 8 paths, the paper's baseline, or MODE_SGBM_3WAY,
///   OpenCV's fastest.
/// @param disparity_px  range.invalid() where OpenCV finds nothing.
/// @param principal_offset_px  is subtracted, as in this package; see StereoRig::principalOffset.
void opencvDisparity(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityRange& range,
                     int mode, cv::Mat1f& disparity_px, double principal_offset_px = 0);

/// OpenCV.
/// @param aligned  whether the rows of the images are aligned first, as in this package.
std::unique_ptr<DisparityMethod> opencvMethod(int mode, const DisparityParams& params,
                                              bool aligned);

}  // namespace predictive_stereo
