/// The block diagram of the paper: one frame in, disparity with variance and moving objects out.
#pragma once

#include <optional>
#include <vector>

#include "predictive_stereo/coarse_matcher.h"
#include "predictive_stereo/correction.h"
#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/prediction.h"
#include "predictive_stereo/row_alignment.h"
#include "predictive_stereo/search_ranges.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

struct DisparityParams {
  MatcherParams matcher;
  RowAlignmentParams row_alignment;
  PredictionParams prediction;
  SearchRangeParams search;
  CorrectionParams correction;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("matcher", matcher);
    v("row_alignment", row_alignment);
    v("prediction", prediction);
    v("search", search);
    v("correction", correction);
  }
};

/// The maps of one frame, as published. Callers may provide the memory: buffers of the right size
/// and type are written in place. See DisparityRange for invalid disparities; variances are 0
/// there.
struct DisparityOutput {
  cv::Mat1f disparity_px;            ///< filtered, then 3x3 median
  cv::Mat1f disparity_variance_px2;  ///< variance of disparity_px
  cv::Mat1f measured_disparity_px;   ///< this frame's match alone
  cv::Mat1f measured_variance_px2;
  cv::Mat1f predicted_disparity_px;  ///< from the past alone; all invalid without a past
  cv::Mat1f predicted_variance_px2;
  cv::Mat1w search_width_px;  ///< disparities searched
  RowAlignment row_alignment;
  bool predicted = false;  ///< whether the past was used
  double mean_search_width_px = 0;
  double full_search_fraction = 0;  ///< share of pixels searched over the whole range
};

/// Duration of one stage of one frame, for diagnostics and benchmarks.
struct StageTime {
  const char* name;
  double ms;
};
using StageTimes = std::vector<StageTime>;

/// Disparity with prediction: the closed loop of the paper's block diagram.
///
/// A frame comes in two steps, so that the first can run while the ego-motion is still computed.
class DisparityEstimator {
 public:
  explicit DisparityEstimator(const DisparityParams& params);

  /// Step 1: what needs no past. Half-resolution match and row alignment.
  void prepare(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& rig);

  /// Step 2: prediction, search ranges, matching, correction.
  /// @param motion  from the frame that was last estimated to the prepared one; none: the frame is
  ///   matched without prediction, and the filters start anew.
  void estimate(const std::optional<CameraMotion>& motion, DisparityOutput& output);

  void reset();
  const StageTimes& times() const { return times_; }

 private:
  DisparityParams params_;
  StereoRig rig_;
  StageTimes times_;
  CoarseMatcher coarse_matcher_;
  RowAligner row_aligner_;
  StereoMatcher matcher_;
  DisparityState state_;
};

}  // namespace predictive_stereo
