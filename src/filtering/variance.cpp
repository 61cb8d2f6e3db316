#include "predictive_stereo/variance.h"

#include <algorithm>

#include "filtering/correction_rows.h"

namespace predictive_stereo {

void measurementVariance(const cv::Mat1f& measured_disparity_px, const cv::Mat1b& ambiguity,
                         const DisparityRange& range, const VarianceParams& params,
                         cv::Mat1f& variance_px2) {
  MeasurementTerms terms;
  for (int i = 0; i < 256; ++i) {
    const double t =
        std::max(0.0, (i / 255.0 - params.ambiguity_onset) / (1.0 - params.ambiguity_onset));
    terms.sigma_by_ambiguity[i] =
        static_cast<float>(params.sigma_floor_px + params.sigma_ambiguous_px * t * t);
  }
  terms.sigma_per_disparity = static_cast<float>(params.sigma_per_disparity);
  terms.smallest_valid = static_cast<float>(range.min_disparity);
  variance_px2.create(measured_disparity_px.size());
  cv::parallel_for_(cv::Range(0, variance_px2.rows), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      measurementVarianceRow(measured_disparity_px[y], ambiguity[y], variance_px2.cols, terms,
                             variance_px2[y]);
  });
}

void publishedVariance(const cv::Mat1f& published_disparity_px, const DisparityState& state,
                       const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
                       const cv::Mat1f& measured_variance_px2, const DisparityRange& range,
                       const VarianceParams& params, cv::Mat1f& variance_px2) {
  const auto squared = [](double sigma_px) { return static_cast<float>(sigma_px * sigma_px); };
  PublishedTerms terms;
  terms.smallest_valid = static_cast<float>(range.min_disparity);
  terms.unpredicted_px2 = squared(params.sigma_unpredicted_px);
  terms.edge_px2 = squared(params.sigma_edge_px);
  terms.kept_px2 = squared(params.sigma_kept_px);
  terms.kept_edge_px2 = squared(params.sigma_kept_edge_px);
  terms.filled_px2 = squared(params.sigma_filled_px);
  terms.largest_innovation_px = static_cast<float>(params.max_innovation_px);
  terms.innovation_weight = static_cast<float>(params.innovation_weight);
  variance_px2.create(published_disparity_px.size());
  cv::parallel_for_(cv::Range(0, variance_px2.rows), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      publishedVarianceRow({published_disparity_px[y], state.disparity_px[y], state.variance_px2[y],
                            prediction.disparity_px[y], prediction.near_edge[y],
                            measured_disparity_px[y], measured_variance_px2[y], variance_px2[y]},
                           variance_px2.cols, terms);
  });
}

}  // namespace predictive_stereo
