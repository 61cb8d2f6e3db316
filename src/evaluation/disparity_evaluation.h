/// Methods that estimate disparities, and their results on sequences.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "evaluation/disparity_metrics.h"
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
  /// Computes what orders the pixels by their certainty: the larger, the less certain. OpenCV: the
  /// difference between left and right disparities [px], from a second match of the right image;
  /// the number of disparities where the right image has none. Empty: the variance orders them.
  std::function<cv::Mat1f()> doubt;
};

/// A method that estimates disparities, called with each frame of a sequence in their order.
using DisparityMethod = std::function<void(const MethodInput&, MethodOutput&)>;

/// This package with a given ego-motion; moving objects are detected and fed back.
DisparityMethod predictiveMethod(const PipelineParams& params);

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
DisparityMethod opencvMethod(int mode, const DisparityParams& params, bool aligned);

/// Results of one method on one sequence, or on several together.
struct DisparityEvaluation {
  std::string method;
  int images = 0;
  double mean_ms = 0;
  MeanDisparityScore score;

  // The following only for methods of this package.
  MeanDisparityScore measured;  ///< of this frame's match alone
  double mean_width_px = 0;
  VarianceCalibration variance;

  struct Frame {
    int index;
    double d1_percent, d1_filled_percent, width_px;
  };
  std::vector<Frame> series;  ///< of the frames with truth
};

/// A method with its name on the command line.
struct NamedMethod {
  std::string name;
  std::function<DisparityMethod()> make;
};

/// New instances of the methods, without a past.
std::vector<DisparityMethod> startMethods(const std::vector<NamedMethod>& methods);

/// Called with each frame, its index, a method's index and its output.
using FrameCallback = std::function<void(const SequenceFrame&, int, size_t, const MethodOutput&)>;

/// Adds a sequence to the evaluation of each method. All methods process a
/// frame before the next one is read; ego-motion is estimated once for all of them.
/// @param params  of the ego-motion; its disparity range is that of the scores.
/// @param max_frames  0: all.
/// @param seen  may be empty.
void evaluateDisparity(const Sequence& sequence, const std::vector<NamedMethod>& methods,
                       const PipelineParams& params, int max_frames, const FrameCallback& seen,
                       std::vector<DisparityEvaluation>& evaluations);

}  // namespace predictive_stereo
