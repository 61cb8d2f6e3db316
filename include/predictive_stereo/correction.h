/// The correction step of the pixel-wise Kalman filters: the paper's eq. 5 and 6.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/prediction.h"

namespace predictive_stereo {

struct CorrectionParams {
  double measurement_noise_px2 = 0.454;  ///< r of eq. 6
  double gate_sigma =
      3.0;  ///< a larger |innovation| resets the filter to the measurement; 0: never
  int max_missed_frames = 3;  ///< predictions outlive this many frames without a measurement

  template <class Visitor>
  void visit(Visitor&& v) {
    v("measurement_noise_px2", measurement_noise_px2, 1e-6, 100.0);
    v("gate_sigma", gate_sigma, 0.0, 100.0);
    v("max_missed_frames", max_missed_frames, 0, 100);
  }
};

/// Updates the filters with this frame's measurement: d = d_pred + K (d_z - d_pred), p = (1 - K)^2
/// p_pred + K^2 r, K = p_pred / (p_pred + r). Without a prediction, or where the innovation fails
/// the gate, the filter starts anew with the measurement; without a measurement the prediction
/// lives on until max_missed_frames is exceeded, but only if two successive frames have agreed on
/// it before: a filter that starts anew counts as having missed max_missed_frames. A surface that
/// only one frame has seen may be a false match.
///
/// A prediction is dropped where the right camera sees through it: where it matches a surface more
/// than 3 px farther on the line of sight to this point, no surface can be there. So the traces of
/// moving objects vanish, and false matches beside near surfaces. A nearer match hides the point
/// and decides nothing.
///
/// All maps have the size of the prediction's; this is not checked. `state` is overwritten.
void correct(const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
             const DisparityRange& range, const CorrectionParams& params, DisparityState& state);

}  // namespace predictive_stereo
