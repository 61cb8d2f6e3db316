/// The stages of one frame's disparities, without a memory of their own: see Pipeline for the loop.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "predictive_stereo/coarse_matcher.h"
#include "predictive_stereo/correction.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/post_filter.h"
#include "predictive_stereo/prediction.h"
#include "predictive_stereo/region_filter.h"
#include "predictive_stereo/row_alignment.h"
#include "predictive_stereo/search_ranges.h"
#include "predictive_stereo/stage_times.h"
#include "predictive_stereo/stereo_rig.h"
#include "predictive_stereo/variance.h"

namespace predictive_stereo {

struct DisparityParams {
  MatcherParams matcher;
  RowAlignmentParams row_alignment;
  PredictionParams prediction;
  SearchRangeParams search;
  CorrectionParams correction;
  VarianceParams variance;
  int min_support = 10;  ///< see filterBySupport; applied to the match and to the filters; 0: off
  int min_region_px = 100;  ///< smaller regions of the match are dropped, at full and at half
                            ///< resolution, see RegionFilter; 0: none
  int max_hole_px = 40;  ///< narrower holes are filled in the published disparity where both sides
                         ///< agree or one hides them, see post_filter.h; 0: none

  /// What moved by itself in the frame before enters neither ranges nor filters, see Pipeline.
  bool use_moving_mask = true;
  /// Disparities are corrected by what the ego-motion finds them to lack, where that is more than
  /// 0.25 px and certain: see ColumnOffset.
  bool correct_columns = true;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("matcher", matcher);
    v("row_alignment", row_alignment);
    v("prediction", prediction);
    v("search", search);
    v("correction", correction);
    v("variance", variance);
    v("min_support", min_support, 0, 25);
    v("min_region_px", min_region_px, 0, 100000);
    v("max_hole_px", max_hole_px, 0, 1000);
    v("use_moving_mask", use_moving_mask);
    v("correct_columns", correct_columns);
  }
};

/// The maps of one frame, as published. Callers may provide the memory: buffers of the right size
/// and type are written in place. See DisparityRange for invalid disparities; variances are 0
/// there.
struct DisparityOutput {
  cv::Mat1f disparity_px;  ///< filtered, narrow holes filled, 3x3 median
  cv::Mat1f disparity_variance_px2;
  cv::Mat1f measured_disparity_px;  ///< this frame's match alone
  cv::Mat1f measured_variance_px2;
  cv::Mat1f predicted_disparity_px;  ///< from the past alone; all invalid without a past
  cv::Mat1f predicted_variance_px2;  ///< see Prediction
  cv::Mat1w search_width_px;  ///< disparities asked for; without matcher/exact_ranges more are
                              ///< searched, 16 at least
  cv::Mat1b ambiguity;        ///< of the measured disparity, see Match
  RowOffsetModel row_alignment;
  bool predicted = false;  ///< whether the past was used
};

/// The blocks of the paper's block diagram, from the images to the published disparity. A frame's
/// steps come in the order of their declaration, but matchCoarsely() and predict() do not need each
/// other and may run at the same time. The images must stay alive and unchanged all the time.
class DisparityEstimator {
 public:
  /// @throws std::invalid_argument for parameters outside their limits.
  explicit DisparityEstimator(const DisparityParams& params);

  /// @param left, right  rectified 8-bit grey images of rig.size.
  void begin(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& rig);
  /// Half-resolution match and row alignment, which need no past; each only where it is needed.
  void matchCoarsely();
  /// The filters of an earlier frame, moved by the camera's motion since then. Without a motion, or
  /// where `past` is empty, nothing is predicted.
  void predict(const DisparityState& past, const std::optional<CameraMotion>& motion,
               DisparityOutput& output);
  void chooseRanges(DisparityOutput& output);
  /// The measurement and its variance.
  void match(DisparityOutput& output);
  /// Prediction and measurement become this frame's filters.
  void correct(const DisparityOutput& output, DisparityState& filters);
  /// `disparity_px` and its variance. May run beside whatever only reads the filters.
  void publish(const DisparityState& filters, DisparityOutput& output);

  /// Other parameters from the next frame on. Not between begin() and publish().
  /// @throws std::invalid_argument for what the constructor refuses; nothing has changed then.
  void setParams(const DisparityParams& params);
  /// Forgets the row alignment of earlier frames.
  void reset() { row_aligner_.reset(); }

  const DisparityParams& params() const { return params_; }
  /// The instruction set that matching runs on.
  const std::string& simdTarget() const { return matcher_.simdTarget(); }
  /// Of the last frame.
  const StageTimes& times() const { return times_; }

  // Intermediate results of the last frame.
  const cv::Mat1b& alignedRight() const { return aligned_right_; }
  const SearchRanges& ranges() const { return ranges_; }

 private:
  DisparityParams params_;
  CoarseMatcher coarse_matcher_;
  RowAligner row_aligner_;
  Predictor predictor_;
  SearchRangeBuilder range_builder_;
  StereoMatcher matcher_;
  RegionFilter region_filter_;

  StereoRig rig_;
  cv::Mat1b left_, right_, shifted_right_, aligned_right_;
  cv::Mat1f coarse_disparity_px_;
  RowOffsetModel row_alignment_;
  Prediction prediction_;
  SearchRanges ranges_;
  Match match_;
  cv::Mat1f corrected_disparity_px_, median_disparity_px_;
  StageTimes coarse_times_, times_;
};

}  // namespace predictive_stereo
