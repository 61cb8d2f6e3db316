/// The prediction step of the pixel-wise Kalman filters: the paper's eq. 2-4.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"

namespace predictive_stereo {

/// In place of a number of missed frames: the pixel is of a moving object. Its prediction is not
/// used: neither for search ranges, nor for the filter.
constexpr unsigned char kMovesByItself = 255;

/// The filters' state, one filter a pixel: the only thing that matching carries to the next frame.
struct DisparityState {
  cv::Mat1f disparity_px;  ///< range.invalid() where unknown
  cv::Mat1f variance_px2;  ///< 0 where unknown
  /// Frames since the pixel was last measured (CorrectionParams::max_missed_frames where only one
  /// frame has measured it, see correct()), or kMovesByItself.
  cv::Mat1b missed_frames;

  bool empty() const { return disparity_px.empty(); }
};

/// Adds a constant to all known disparities; those that leave the range below become unknown.
void addToDisparities(const DisparityRange& range, double offset_px, cv::Mat1f& disparity_px);
void addToDisparities(const DisparityRange& range, double offset_px, DisparityState& state);

struct PredictionParams {
  double process_noise_px2 = 0.051;   ///< q of eq. 4, or its floor where motion covariance is used
  bool use_motion_covariance = true;  ///< q grows by J Sigma J^T of the ego-motion
  double edge_jump_px = 3.0;          ///< neighbours that differ by more are a discontinuity
  int edge_margin_px = 2;             ///< pixels this near to a discontinuity are reset
  bool reject_near_edges = false;     ///< these have no prediction then, as in the paper

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
  /// is count^2 / 12: every disparity of the range is equally likely there.
  cv::Mat1f variance_px2;
  cv::Mat1b missed_frames;  ///< as in DisparityState, moved along
  cv::Mat1b near_edge;      ///< 255 near a predicted discontinuity
};

/// Moves the filters of the previous frame into the current one. Keeps its buffers between calls.
class Predictor {
 public:
  Predictor(const DisparityRange& range, const PredictionParams& params);

  /// Forward warp by H (eq. 2) with a z-buffer (the nearer surface wins), variance by Phi^2 p + q
  /// (eq. 3, 4); a hole with two known neighbours in its row or its column takes their average (the
  /// zooming effect); then the reset near discontinuities. The result does not depend on the number
  /// of threads. Memory of `prediction` that has gaps between its rows is replaced.
  void predict(const DisparityState& previous, const StereoRig& rig, const CameraMotion& motion,
               Prediction& prediction);

  /// The prediction where there is no past: unknown everywhere.
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
  // Where each pixel of the previous frame goes: its index in the current frame (-1: nowhere), and
  // its disparity and variance there.
  cv::Mat1i target_;
  cv::Mat1f target_disparity_px_, target_variance_px2_;
  std::vector<cv::Range> target_rows_;  // the rows that a row of the previous frame goes to
  // Of every band of rows: where columns have edges, and the edges of its rows and of those around
  // it.
  cv::Mat1b marks_;
};

}  // namespace predictive_stereo
