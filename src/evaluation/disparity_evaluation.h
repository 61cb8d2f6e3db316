#pragma once

#include <functional>
#include <string>
#include <vector>

#include "evaluation/disparity_method.h"
#include "evaluation/disparity_metrics.h"

namespace predictive_stereo {

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
