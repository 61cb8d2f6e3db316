/// The block diagram of the paper: one frame in, disparity with variance and moving objects out.
#pragma once

#include <optional>
#include <string>

#include "predictive_stereo/coarse_matcher.h"
#include "predictive_stereo/correction.h"
#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/post_filter.h"
#include "predictive_stereo/prediction.h"
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
  int max_hole_px = 40;  ///< narrower holes are filled in the published disparity where both sides
                         ///< agree or one hides them, see fillHoles; 0: none

  /// What moved by itself in the frame before, by markMoving(), enters neither ranges nor filters.
  bool use_moving_mask = true;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("matcher", matcher);
    v("row_alignment", row_alignment);
    v("prediction", prediction);
    v("search", search);
    v("correction", correction);
    v("variance", variance);
    v("min_support", min_support, 0, 25);
    v("max_hole_px", max_hole_px, 0, 1000);
    v("use_moving_mask", use_moving_mask);
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
  cv::Mat1w search_width_px;  ///< disparities asked for; the matcher looks at 16 or more around
  cv::Mat1b ambiguity;        ///< of the measured disparity, see Match
  RowOffsetModel row_alignment;
  bool predicted = false;  ///< whether the past was used
  bool carried = false;    ///< whether this frame is the past of the next one, see predict()
};

/// Disparity with prediction: the closed loop of the paper's block diagram.
///
/// A frame comes in steps, so that what needs no motion can run beside the ego-motion and the
/// prediction: begin(), then matchCoarsely() and, in any order or at the same time, predict(), then
/// measure() and publish(). The images must stay alive and unchanged all the time.
class DisparityEstimator {
 public:
  /// @throws std::invalid_argument for parameters outside their limits.
  explicit DisparityEstimator(const DisparityParams& params);

  /// @param left, right  rectified 8-bit grey images of rig.size.
  /// @throws std::invalid_argument where sizes differ from rig.size.
  void begin(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& rig);
  /// Half-resolution match and row alignment, which need no past.
  void matchCoarsely();
  /// The past, moved by the ego-motion.
  /// @param motion  from the past, the last frame that was carried, to this one. None: it is not
  ///   known, and the frame is matched without prediction. The past is then kept for the frames
  ///   after, so that one frame without motion costs no more than itself; after
  ///   correction/max_missed_frames of them this frame takes its place.
  void predict(const std::optional<CameraMotion>& motion, DisparityOutput& output);
  /// Search ranges, matching, correction: everything but `disparity_px` and its variance.
  void measure(DisparityOutput& output);
  /// And those two. May run beside markMoving().
  void publish(DisparityOutput& output);

  /// All before the motion is known, one step after the other.
  void prepare(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& rig) {
    begin(left, right, rig);
    matchCoarsely();
  }
  /// And all the others.
  void estimate(const std::optional<CameraMotion>& motion, DisparityOutput& output) {
    predict(motion, output);
    measure(output);
    publish(output);
  }

  /// Tells what moved by itself in the frame that was estimated last: where
  /// params().use_moving_mask, its disparities do not enter the next frame's ranges and filters.
  /// See kMovesByItself.
  /// @param mask  255 on moving objects, as Detections::mask, of that frame's size.
  /// @throws std::invalid_argument for another size.
  void markMoving(const cv::Mat1b& mask);

  /// Other parameters from the next frame on. What is known of the past is kept, unless the range
  /// of disparities becomes another one. Not between begin() and measure().
  /// @throws std::invalid_argument for what the constructor refuses; nothing has changed then.
  void setParams(const DisparityParams& params);

  /// Forgets the filters: the next frame is matched without prediction and starts them anew.
  void forgetPast();
  /// Forgets everything, the row alignment too: for another sequence.
  void reset();

  const DisparityParams& params() const { return params_; }
  /// The instruction set that matching runs on.
  const std::string& simdTarget() const { return matcher_.simdTarget(); }
  /// Of the last frame.
  const StageTimes& times() const { return times_; }

 private:
  DisparityParams params_;
  CoarseMatcher coarse_matcher_;
  RowAligner row_aligner_;
  Predictor predictor_;
  SearchRangeBuilder range_builder_;
  StereoMatcher matcher_;

  // The frame in work.
  StereoRig rig_;
  cv::Mat1b left_, right_, shifted_right_, aligned_right_;
  cv::Mat1f coarse_disparity_px_;
  RowOffsetModel row_alignment_;
  Prediction prediction_;
  SearchRanges ranges_;
  Match match_;
  cv::Mat1f corrected_disparity_px_, median_disparity_px_;
  StageTimes coarse_times_, times_;

  DisparityState unlinked_;  // the filters of a frame that is not carried

  // What is carried to the next frame.
  DisparityState past_;
  int unlinked_frames_ = 0;  // since then
};

struct PipelineParams {
  EgoMotionParams ego_motion;
  DisparityParams disparity;
  DetectionParams detection;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("ego_motion", ego_motion);
    v("disparity", disparity);
    v("detection", detection);
  }
};

struct PipelineOutput {
  EgoMotionEstimate ego_motion;
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();  ///< the first frame is the origin
  DisparityOutput disparity;
  Detections detections;
};

/// The whole package on one stereo sequence, without ROS.
class Pipeline {
 public:
  explicit Pipeline(const PipelineParams& params);

  /// Frames must come in the order of their stamps.
  void process(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& rig, double stamp_s,
               PipelineOutput& output);
  void reset();

  const StageTimes& times() const { return times_; }

 private:
  EgoMotion ego_motion_;
  DisparityEstimator disparity_;
  MovingObjectDetector detector_;
  Eigen::Isometry3d T_odom_cam_ = Eigen::Isometry3d::Identity();
  int frames_since_past_ = 0;  // since the frame that disparity_ carries on
  StageTimes times_;
};

}  // namespace predictive_stereo
