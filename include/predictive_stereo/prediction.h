/// The prediction step of the pixel-wise Kalman filters: the paper's eq. 2-4.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"

namespace predictive_stereo {

/// The filters' state, one filter a pixel: the only thing that matching carries to the next frame.
struct DisparityState {
  cv::Mat1f disparity_px;   ///< range.invalid() where unknown
  cv::Mat1f variance_px2;   ///< 0 where unknown
  cv::Mat1b missed_frames;  ///< frames since the pixel was last measured

  bool empty() const { return disparity_px.empty(); }
};

struct PredictionParams {
  double process_noise_px2 = 0.1;     ///< q of eq. 4, or its floor where motion covariance is used
  bool use_motion_covariance = true;  ///< q grows by J Sigma J^T of the ego-motion
  double edge_jump_px = 3.0;          ///< neighbours that differ by more are a discontinuity
  int edge_margin_px = 2;             ///< predictions this near to a discontinuity are dropped
  int max_missed_frames = 3;          ///< a pixel not measured for longer is dropped

  template <class Visitor>
  void visit(Visitor&& v) {
    v("process_noise_px2", process_noise_px2, 1e-6, 100.0);
    v("use_motion_covariance", use_motion_covariance);
    v("edge_jump_px", edge_jump_px, 0.5, 64.0);
    v("edge_margin_px", edge_margin_px, 0, 10);
    v("max_missed_frames", max_missed_frames, 0, 100);
  }
};

/// What the past says of the current frame.
struct Prediction {
  cv::Mat1f disparity_px;   ///< range.invalid() where nothing is predicted
  cv::Mat1f variance_px2;   ///< 0 where nothing is predicted
  cv::Mat1b missed_frames;  ///< as in DisparityState, moved along
  cv::Mat1b near_edge;      ///< 255 near a predicted discontinuity
  cv::Mat1b filled;         ///< 255 where two neighbours gave the value (the zooming effect)

  bool empty() const { return disparity_px.empty(); }
};

}  // namespace predictive_stereo
