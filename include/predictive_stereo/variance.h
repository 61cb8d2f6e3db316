/// How far a disparity can be trusted.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/prediction.h"

namespace predictive_stereo {

/// sigma = floor + ambiguous t^2 + per_disparity d, where t grows from 0 to 1 as the ambiguity
/// (lowest over second lowest aggregated cost) goes from `onset` to 1.
struct MeasurementNoiseParams {
  double sigma_floor_px = 0.30;
  double sigma_ambiguous_px = 1.0;
  double sigma_per_disparity = 0.4 / 64;
  double ambiguity_onset = 0.6;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("sigma_floor_px", sigma_floor_px, 0.01, 10.0);
    v("sigma_ambiguous_px", sigma_ambiguous_px, 0.0, 100.0);
    v("sigma_per_disparity", sigma_per_disparity, 0.0, 1.0);
    v("ambiguity_onset", ambiguity_onset, 0.0, 0.99);
  }
};

/// Variance [px^2] of each measured disparity from the shape of its aggregated cost; 0 where
/// nothing was measured.
void measurementVariance(const cv::Mat1f& measured_disparity_px, const cv::Mat1b& ambiguity,
                         const DisparityRange& range, const MeasurementNoiseParams& params,
                         cv::Mat1f& variance_px2);

/// Variance [px^2] of published disparities, 0 where unknown. The filter's own p counts the errors
/// of successive matches as independent, which they are not: what was measured in this frame keeps
/// the variance of its match, reduced by the filter's gain; what only lives on keeps its predicted
/// variance; what was filled gets a constant one.
void filteredVariance(const cv::Mat1f& published_disparity_px, const DisparityState& state,
                      const cv::Mat1f& measured_variance_px2, const DisparityRange& range,
                      double measurement_noise_px2, cv::Mat1f& variance_px2);

}  // namespace predictive_stereo
