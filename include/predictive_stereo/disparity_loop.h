/// The disparity of a stereo sequence, each frame predicted from the past.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "predictive_stereo/coarse_matcher.h"
#include "predictive_stereo/correction.h"
#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/past.h"
#include "predictive_stereo/photometric_residual.h"
#include "predictive_stereo/post_filter.h"
#include "predictive_stereo/prediction.h"
#include "predictive_stereo/region_filter.h"
#include "predictive_stereo/row_alignment.h"
#include "predictive_stereo/search_ranges.h"
#include "predictive_stereo/stage_times.h"
#include "predictive_stereo/stereo_frame.h"
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

/// The blocks of the paper's Fig. 1, from the images to the published disparity.
///
/// Disparities are matched with the right camera's cx corrected by the column offset
/// (correct_columns). The corrected rig goes with the frame: who keeps disparities of earlier
/// frames (Past, MovingObjectDetector) compares it with the rig before.
class DisparityLoop {
 public:
  /// Returns the camera's motion since the past; nullopt: not known. It may wait.
  using Motion = std::function<std::optional<CameraMotion>(Past&)>;
  /// Returns the mask of moving objects of this earlier frame: 255 on them, 0 elsewhere, of
  /// rig.size; empty: not known. It may wait.
  using Moved = std::function<cv::Mat1b(Stamp)>;

  /// The stages that depend on parameters.
  struct Stages {
    /// @throws std::invalid_argument if a parameter is outside its limits, or for what the
    ///   constructors of StereoMatcher and SearchRangeBuilder refuse.
    explicit Stages(const DisparityParams& params);

    CoarseMatcher coarse_matcher;
    RowAligner row_aligner;
    Predictor predictor;
    SearchRangeBuilder range_builder;
    StereoMatcher matcher;
  };

  /// @param max_gap_s  [s] a longer gap between two frames breaks the sequence.
  /// @throws std::invalid_argument as Stages does.
  DisparityLoop(const DisparityParams& params, double max_gap_s);

  /// Takes a frame. If it does not continue the previous one, all earlier frames are forgotten.
  /// If the result says isIgnored(), measure() must not be called. The images must stay alive and
  /// unchanged until publish() is done.
  /// @throws std::invalid_argument if an image does not have rig.size; the state is then unchanged.
  SequenceGuard::Result begin(const StereoFrame& frame);
  /// All maps but the published ones, of the frame that begin() took.
  /// @param motion  called once, while the images are matched at half resolution.
  /// @param moved  called only if the mask is needed; may be empty.
  /// @throws std::invalid_argument if a mask does not have rig.size, if images are smaller than 2x2
  ///   pixels, or if cx_left - cx_right leaves no pixel a disparity to search; and whatever the
  ///   functions throw.
  void measure(const Motion& motion, const Moved& moved, DisparityOutput& maps);
  /// The published maps. May run at the same time as code that only reads the past.
  void publish(DisparityOutput& maps);

  /// begin(), measure() and publish() in one call.
  /// @returns false for a duplicate or a late frame; `maps` are then unchanged.
  bool process(const StereoFrame& frame, const Motion& motion, DisparityOutput& maps) {
    if (begin(frame).isIgnored()) return false;
    measure(motion, {}, maps);
    publish(maps);
    return true;
  }

  /// Moving objects of the last frame are no part of the past, if use_moving_mask.
  /// @throws std::invalid_argument as Past::eraseMoving does.
  void eraseMoving(const cv::Mat1b& mask);
  /// The column offset that ego-motion has estimated, for the following frames.
  void setColumnOffset(const ColumnOffset& offset) { next_offset_ = offset; }

  /// Sets parameters for the next frame. The past is kept, unless the disparity range changes.
  /// @throws std::invalid_argument as the constructor does; the parameters are then unchanged.
  void setParams(const DisparityParams& params);
  void reset();

  /// The column offset of this frame, and its rig, corrected by it.
  const ColumnOffset& columnOffset() const { return offset_; }
  const StereoRig& rig() const { return rig_; }
  const Past& past() const { return past_; }
  const DisparityParams& params() const { return params_; }
  /// The SIMD target of the matcher, see simd_target.h.
  const std::string& simdTarget() const { return stages_.matcher.simdTarget(); }

  // Of the last frame.
  const StageTimes& times() const { return times_; }
  const cv::Mat1b& alignedRight() const { return aligned_right_; }
  const SearchRanges& ranges() const { return ranges_; }

 private:
  void correctColumns();
  // The steps of measure(), in this order; only the first two may run at the same time.
  void matchCoarsely();
  void predict(const std::optional<CameraMotion>& motion, DisparityOutput& maps);
  void chooseRanges(DisparityOutput& maps);
  void match(DisparityOutput& maps);
  void correct(const DisparityOutput& maps);
  void leaveOutRobot(cv::Mat1f& disparity_px) const;

  DisparityParams params_;
  Stages stages_;
  RegionFilter region_filter_;
  PhotometricResidual photometric_residual_;
  SequenceGuard guard_;
  StereoFrame frame_;  // that begin() took
  StereoRig rig_;      // its rig, with cx_right_px corrected
  ColumnOffset offset_, next_offset_;
  Past past_;

  // Of this frame.
  cv::Mat1b shifted_right_, aligned_right_;
  cv::Mat1f coarse_disparity_px_;
  RowOffsetModel row_alignment_;
  Prediction prediction_;
  SearchRanges ranges_;
  Match match_;
  cv::Mat1f corrected_disparity_px_, certain_disparity_px_;
  cv::Mat1f filled_disparity_px_, median_disparity_px_, residual_share_;
  StageTimes coarse_times_, times_;
};

}  // namespace predictive_stereo
