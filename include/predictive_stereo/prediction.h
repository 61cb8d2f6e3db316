/// The prediction step of the pixel-wise Kalman filters: the paper's eq. 2-4.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"

namespace predictive_stereo {

/// Value of missed_frames for pixels of moving objects. Their prediction is used neither for search
/// ranges nor for the filter.
constexpr unsigned char kMovesByItself = 255;
/// Value of missed_frames for pixels that only one frame has measured, see correct().
constexpr unsigned char kSeenOnce = 254;

/// The state of the filters, one filter per pixel. Matching passes nothing else to the next frame.
/// All maps have the images' size.
struct DisparityState {
  cv::Mat1f disparity_px;  ///< range.invalid() where unknown
  /// Where the disparity is unknown it means nothing: 0, or that of a disparity without support.
  cv::Mat1f variance_px2;
  /// Frames since the pixel was last measured, kSeenOnce, or kMovesByItself.
  cv::Mat1b missed_frames;

  bool empty() const { return disparity_px.empty(); }
};

/// Adds a constant to all known disparities. Those below the range become range.invalid().
void addToDisparities(const DisparityRange& range, double offset_px, cv::Mat1f& disparity_px);
/// The same for a state, where the variance of unknown disparities is set to 0. May be empty.
void addToDisparities(const DisparityRange& range, double offset_px, DisparityState& state);

struct PredictionParams {
  double process_noise_px2 = 0.051;   ///< q of eq. 4; its minimum if use_motion_covariance
  bool use_motion_covariance = true;  ///< adds J Sigma J^T of the ego-motion to q
  double edge_jump_px = 3.0;          ///< neighbours that differ by more are a discontinuity
  int edge_margin_px = 2;             ///< pixels this near to a discontinuity are reset
  bool reject_near_edges = false;     ///< no prediction for these pixels, as in the paper

  template <class Visitor>
  void visit(Visitor&& v) {
    v("process_noise_px2", process_noise_px2, 1e-6, 100.0);
    v("use_motion_covariance", use_motion_covariance);
    v("edge_jump_px", edge_jump_px, 0.5, 64.0);
    v("edge_margin_px", edge_margin_px, 0, 10);
    v("reject_near_edges", reject_near_edges);
  }
};

/// The filters of the past, moved into the current frame.
struct Prediction {
  cv::Mat1f disparity_px;  ///< range.invalid() where nothing is predicted
  /// 0 where nothing is predicted or the prediction is rejected. Near predicted discontinuities it
  /// is count^2 / 12, as every disparity of the range is equally likely there.
  cv::Mat1f variance_px2;
  cv::Mat1b missed_frames;  ///< as in DisparityState, warped with the disparities
  cv::Mat1b near_edge;      ///< 255 near a predicted discontinuity, 0 elsewhere
};

/// Moves the filters of the previous frame into the current one. Keeps its buffers between calls.
class Predictor {
 public:
  /// @throws std::invalid_argument if a parameter is outside its limits.
  Predictor(const DisparityRange& range, const PredictionParams& params);

  /// Forward warp by H (eq. 2) with a z-buffer (the nearer surface wins), and variance Phi^2 p + q
  /// (eq. 3, 4). Then a hole with two known neighbours in its row or its column gets their average
  /// (section 2.4, zooming effect). Then pixels near discontinuities are reset. The result does not
  /// depend on the number of threads.
  /// @param previous  not empty, of rig.size; this is not checked.
  /// @param prediction  output of rig.size. Maps that are not continuous are allocated anew.
  void predict(const DisparityState& previous, const StereoRig& rig, const CameraMotion& motion,
               Prediction& prediction);

  /// The prediction without a past: unknown everywhere.
  void predictNothing(cv::Size size, Prediction& prediction) const;

 private:
  void warp(const DisparityState& previous, const StereoRig& rig, const CameraMotion& motion);
  void scatterAndFill(const DisparityState& previous, Prediction& prediction) const;
  void scatterInto(const cv::Range& rows, const DisparityState& previous,
                   Prediction& prediction) const;
  void markNearEdgesAndAddNoise(const StereoRig& rig, const CameraMotion& motion,
                                Prediction& prediction);
  void rejectNearEdges(Prediction& prediction) const;

  DisparityRange range_;
  PredictionParams params_;
  // Where each pixel of the previous frame is warped to: its index in the current frame (-1:
  // outside), and its disparity and variance there.
  cv::Mat1i target_;
  cv::Mat1f target_disparity_px_, target_variance_px2_;
  std::vector<cv::Range> target_rows_;  // the rows that a row of the previous frame is warped to
};

}  // namespace predictive_stereo
