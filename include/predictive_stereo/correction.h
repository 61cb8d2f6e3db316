/// The correction step of the pixel-wise Kalman filters: the paper's eq. 5 and 6.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/prediction.h"

namespace predictive_stereo {

struct CorrectionParams {
  double measurement_noise_px2 = 0.454;  ///< r of eq. 6
  /// Gate: a larger |innovation|, in standard deviations, resets the filter to the measurement; 0:
  /// no gate.
  double gate_sigma = 3.0;
  int max_missed_frames = 3;  ///< a prediction is kept for this many frames without a measurement

  template <class Visitor>
  void visit(Visitor&& v) {
    v("measurement_noise_px2", measurement_noise_px2, 1e-6, 100.0);
    v("gate_sigma", gate_sigma, 0.0, 100.0);
    v("max_missed_frames", max_missed_frames, 0, 100);  // less than kSeenOnce
  }
};

/// Updates the filters with this frame's measurement (eq. 5 and 6): d = d_pred + K (d_z - d_pred),
/// p = (1 - K)^2 p_pred + K^2 r, K = p_pred / (p_pred + r).
///
/// Without a prediction, or where the innovation fails the gate, the filter is reset to the
/// measurement. Without a measurement the prediction is kept until max_missed_frames is exceeded,
/// but only if two successive frames agreed on it before: a filter that is reset is kSeenOnce. A
/// surface that only one frame has seen may be a false match.
///
/// A prediction without a measurement is dropped where the right camera sees through it: if the
/// right camera matches a surface with a disparity more than 3 px smaller on the line of sight to
/// the predicted point, no surface can be there. This removes the traces of moving objects, and
/// false matches beside near surfaces. A nearer match occludes the point: the prediction stays.
///
/// @param prediction  see Prediction; range.invalid() where nothing is predicted.
/// @param measured_disparity_px  this frame's match; range.invalid() where nothing was measured.
///   It must have the size of the prediction; this is not checked.
/// @param state  output of that size, overwritten.
/// @param principal_offset_px  see StereoRig::principalOffset: the right camera sees only the
///   columns of its image.
void correct(const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
             const DisparityRange& range, const CorrectionParams& params, DisparityState& state,
             double principal_offset_px = 0);

}  // namespace predictive_stereo
