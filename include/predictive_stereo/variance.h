/// How far a disparity can be trusted.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/prediction.h"

namespace predictive_stereo {

/// Standard deviations of disparities [px], by how they came about. The defaults are what
/// estimate_noise found on KITTI and the synthetic street (config/noise_kitti.yaml).
///
/// A match has sigma_match = sigma_floor + sigma_ambiguous t^2 + sigma_per_disparity d, where t
/// grows from 0 to 1 as its ambiguity (lowest over second lowest aggregated cost) goes from
/// `ambiguity_onset` to 1. The filter's own p is not used for what is published: it counts the
/// errors of successive matches as independent, which they are not. What does tell is the
/// innovation.
struct VarianceParams {
  double sigma_floor_px = 0.32;
  double sigma_ambiguous_px = 0.88;
  double sigma_per_disparity = 0.002;
  double ambiguity_onset = 0.47;
  double innovation_weight = 0.5;     ///< share of the squared innovation that adds to the variance
  double max_innovation_px = 4.0;     ///< a larger innovation counts as this one
  double sigma_unpredicted_px = 1.6;  ///< adds to a match that nothing was predicted for
  double sigma_edge_px = 2.5;         ///< adds to a match near a predicted discontinuity
  double sigma_kept_px = 1.6;         ///< adds to a prediction that was not measured
  double sigma_kept_edge_px = 7.3;    ///< of such a prediction near a discontinuity
  double sigma_filled_px = 4.7;       ///< of what was filled

  template <class Visitor>
  void visit(Visitor&& v) {
    v("sigma_floor_px", sigma_floor_px, 0.01, 10.0);
    v("sigma_ambiguous_px", sigma_ambiguous_px, 0.0, 100.0);
    v("sigma_per_disparity", sigma_per_disparity, 0.0, 1.0);
    v("ambiguity_onset", ambiguity_onset, 0.0, 0.99);
    v("innovation_weight", innovation_weight, 0.0, 1.0);
    v("max_innovation_px", max_innovation_px, 0.0, 256.0);
    v("sigma_unpredicted_px", sigma_unpredicted_px, 0.0, 100.0);
    v("sigma_edge_px", sigma_edge_px, 0.0, 100.0);
    v("sigma_kept_px", sigma_kept_px, 0.0, 100.0);
    v("sigma_kept_edge_px", sigma_kept_edge_px, 0.01, 100.0);
    v("sigma_filled_px", sigma_filled_px, 0.01, 100.0);
  }
};

/// Variance [px^2] of each measured disparity from the shape of its aggregated cost; 0 where
/// nothing was measured.
void measurementVariance(const cv::Mat1f& measured_disparity_px, const cv::Mat1b& ambiguity,
                         const DisparityRange& range, const VarianceParams& params,
                         cv::Mat1f& variance_px2);

/// Variance [px^2] of the published disparities, 0 where unknown.
void publishedVariance(const cv::Mat1f& published_disparity_px, const DisparityState& state,
                       const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
                       const cv::Mat1f& measured_variance_px2, const DisparityRange& range,
                       const VarianceParams& params, cv::Mat1f& variance_px2);

}  // namespace predictive_stereo
