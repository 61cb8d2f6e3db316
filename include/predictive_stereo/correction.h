/// The correction step of the pixel-wise Kalman filters: the paper's eq. 5 and 6.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/matcher.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/prediction.h"

namespace predictive_stereo {

struct CorrectionParams {
  double measurement_noise_px2 = 0.4;  ///< r of eq. 6
  double gate_sigma =
      3.0;  ///< a larger |innovation| resets the filter to the measurement; 0: never

  template <class Visitor>
  void visit(Visitor&& v) {
    v("measurement_noise_px2", measurement_noise_px2, 1e-6, 100.0);
    v("gate_sigma", gate_sigma, 0.0, 100.0);
  }
};

/// Updates the filters. Where only one of prediction and measurement exists that one is taken, and
/// `missed_frames` counts on where it is the prediction.
void correct(const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
             const cv::Mat1f& measured_variance_px2, const DisparityRange& range,
             const CorrectionParams& params, DisparityState& state);

}  // namespace predictive_stereo
