#pragma once

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "evaluation/disparity_method.h"
#include "evaluation/disparity_metrics.h"

namespace predictive_stereo {

/// Variance calibration as a function of a key, e.g. the ambiguity: in fine steps, which can be
/// merged to bins of equal population.
class BinnedCalibration {
 public:
  explicit BinnedCalibration(double step, int steps)
      : step_(step), steps_(static_cast<size_t>(steps)) {}
  void add(double key, double error_px, double variance_px2);

  struct Bin {
    double first, last;  ///< of the key
    VarianceCalibration calibration;
  };
  /// At most `count` bins of about equal population, in ascending order of the key.
  std::vector<Bin> bins(int count) const;

 private:
  double step_;
  std::vector<VarianceCalibration> steps_;
};

/// Results of one method on one sequence, or on several together.
struct DisparityEvaluation {
  int images = 0;
  double mean_ms = 0;
  MeanDisparityScore score;
  std::map<std::string, MeanDisparityScore> regions;

  // The following only for methods of this package.
  MeanDisparityScore measured;  ///< of this frame's match alone
  /// Root mean square inlier errors of measured and filtered disparities on the same pixels.
  MeanDisparityScore common_measured, common_filtered;
  double mean_width_px = 0;
  double full_search_percent = 0;  ///< share of pixels searched over the whole range
  VarianceCalibration variance;
  BinnedCalibration variance_by_ambiguity{1.0 / 256, 256};
  BinnedCalibration variance_by_disparity{0.5, 512};
  int64_t without_variance = 0;  ///< valid pixels with truth whose variance is not positive
  std::vector<std::pair<std::string, double>> stage_ms;  ///< mean per image, in order

  struct Frame {
    int index;
    double d1_percent, d1_filled_percent, width_px;
  };
  std::vector<Frame> series;  ///< of the frames with truth
};

/// A method with its name on the command line.
struct NamedMethod {
  std::string name;
  std::function<std::unique_ptr<DisparityMethod>()> make;
};

/// New instances of the methods, without a past.
std::vector<std::unique_ptr<DisparityMethod>> startMethods(const std::vector<NamedMethod>& methods);

/// Called with each frame, its index, a method's index and its output.
using FrameCallback = std::function<void(const SequenceFrame&, int, size_t, const MethodOutput&)>;

/// Adds a sequence to the evaluation of each method (by the method's name). All methods process a
/// frame before the next one is read; ego-motion is estimated once for all of them.
/// @param params  of the ego-motion; its disparity range is that of the scores.
/// @param max_frames  0: all.
/// @param seen  may be empty.
void evaluateDisparity(const Sequence& sequence, const std::vector<NamedMethod>& methods,
                       const PipelineParams& params, int max_frames, const FrameCallback& seen,
                       std::vector<DisparityEvaluation>& evaluations);

}  // namespace predictive_stereo
