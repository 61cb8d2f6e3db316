/// The stages that estimate one frame's disparities. Pipeline runs them, and keeps the filters from
/// frame to frame.
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
  int min_support = 10;  ///< pixels of 5x5 within 1 px of the centre; with fewer unknown; 0: off
  /// Smaller regions of the match (at full and half resolution) and of what is published become
  /// invalid, see RegionFilter; 0: none.
  int min_region_px = 100;
  /// Matches of a larger ambiguity (Match::ambiguity, 0..1) are not published; their pixels may
  /// be filled as holes; 1: all are published.
  double max_ambiguity = 0.9;
  /// Holes of rows and columns up to this length are filled in the published disparity, if both
  /// sides belong to one surface or if they are occlusions, see fillHoles, and their borders by the
  /// median; 0: none (the median fills pixels with five known neighbours, as in the paper).
  int max_hole_px = 40;

  /// Moving objects of the previous frame are used neither for search ranges nor for the filters,
  /// see Pipeline.
  bool use_moving_mask = true;
  /// Adds the column offset that ego-motion estimates to the disparities, if it is certain and
  /// above 0.25 px: see ColumnOffset.
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
    v("max_ambiguity", max_ambiguity, 0.0, 1.0);
    v("max_hole_px", max_hole_px, 0, 1000);
    v("use_moving_mask", use_moving_mask);
    v("correct_columns", correct_columns);
  }
};

/// The maps of one frame, as published, all of rig.size. Disparities are those of StereoRig,
/// without the offset of the principal points. Callers may provide the memory: buffers of the right
/// size and type are written in place. Unknown disparities are DisparityRange::invalid(), and their
/// variances 0.
struct DisparityOutput {
  cv::Mat1f disparity_px;  ///< filtered, no ambiguous matches, narrow holes filled, 3x3 median
  cv::Mat1f disparity_variance_px2;
  cv::Mat1f measured_disparity_px;  ///< this frame's match alone
  cv::Mat1f measured_variance_px2;
  cv::Mat1f predicted_disparity_px;  ///< from the past alone; invalid everywhere without a past
  cv::Mat1f predicted_variance_px2;  ///< see Prediction
  cv::Mat1w search_width_px;  ///< number of disparities in the search range; the matcher searches
                              ///< more, 16 at least, unless matcher/exact_ranges
  cv::Mat1b ambiguity;        ///< of the measured disparity, see Match
  RowOffsetModel row_alignment;
  bool predicted = false;  ///< whether there was a prediction from the past
};

/// The blocks of the paper's Fig. 1, from the images to the published disparity. Call the steps of
/// a frame in the order of their declaration; only matchCoarsely() and predict() are independent
/// and may run at the same time. The images must stay alive and unchanged until publish() is done.
class DisparityEstimator {
 public:
  /// @throws std::invalid_argument if a parameter is outside its limits, or for what the
  ///   constructors of StereoMatcher and SearchRangeBuilder refuse.
  explicit DisparityEstimator(const DisparityParams& params);

  /// Starts a frame.
  /// @param left, right  rectified 8-bit grey images of calibration.size.
  /// @param calibration  its principal points are those of the images, see StereoMatcher.
  /// @param rig  of the disparities: the calibration, or with a corrected cx_right. The right image
  ///   is moved by the correction, see ColumnOffset.
  /// @throws std::invalid_argument if cx_left - cx_right of the calibration leaves no pixel a
  ///   disparity to search; the message has both.
  void begin(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& calibration,
             const StereoRig& rig);
  /// Half-resolution match and row alignment, which do not depend on the past. Each runs only if
  /// the parameters need it.
  /// @throws std::invalid_argument if the images differ in size or are smaller than 2x2 pixels.
  void matchCoarsely();
  /// Moves the filters of an earlier frame by the camera's motion since then (eq. 2-4). Nothing is
  /// predicted without a motion or if `past` is empty.
  /// @param past  its maps must have rig.size; this is not checked.
  void predict(const DisparityState& past, const std::optional<CameraMotion>& motion,
               DisparityOutput& output);
  /// Search ranges from prediction and half-resolution match (section 2.4).
  void chooseRanges(DisparityOutput& output);
  /// The measurement (sections 2.1-2.3) and its variance.
  /// @throws std::invalid_argument if the images are empty or differ in size.
  void match(DisparityOutput& output);
  /// Combines prediction and measurement into this frame's filters (eq. 5 and 6).
  /// @param filters  output, overwritten; may be the state that predict() was given as `past`.
  void correct(const DisparityOutput& output, DisparityState& filters);
  /// `disparity_px` and its variance. May run at the same time as code that only reads the filters.
  void publish(const DisparityState& filters, DisparityOutput& output);

  /// Sets parameters for the next frame. Must not be called between begin() and publish().
  /// @throws std::invalid_argument as the constructor does; the parameters are then unchanged.
  void setParams(const DisparityParams& params);
  /// Forgets the row alignment of earlier frames.
  void reset() { row_aligner_.reset(); }

  const DisparityParams& params() const { return params_; }
  /// The SIMD target of the matcher, see simd_target.h.
  const std::string& simdTarget() const { return matcher_.simdTarget(); }
  /// Stage times of the last frame.
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
  double principal_offset_px_ = 0;  // of the calibration
  double right_shift_px_ = 0;       // of the correction
  cv::Mat1b left_, right_, shifted_right_, aligned_right_;
  cv::Mat1f coarse_disparity_px_;
  RowOffsetModel row_alignment_;
  Prediction prediction_;
  SearchRanges ranges_;
  Match match_;
  cv::Mat1f corrected_disparity_px_, certain_disparity_px_;
  cv::Mat1f filled_disparity_px_, median_disparity_px_;
  StageTimes coarse_times_, times_;
};

}  // namespace predictive_stereo
