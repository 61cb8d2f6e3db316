#include "predictive_stereo/variance.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace predictive_stereo {

void measurementVariance(const cv::Mat1f& measured_disparity_px, const cv::Mat1b& ambiguity,
                         const DisparityRange& range, const VarianceParams& params,
                         cv::Mat1f& variance_px2) {
  std::array<float, 256> sigma_by_ambiguity;
  for (int i = 0; i < 256; ++i) {
    const double t =
        std::max(0.0, (i / 255.0 - params.ambiguity_onset) / (1.0 - params.ambiguity_onset));
    sigma_by_ambiguity[i] =
        static_cast<float>(params.sigma_floor_px + params.sigma_ambiguous_px * t * t);
  }
  const float per_disparity = static_cast<float>(params.sigma_per_disparity);
  const float smallest = static_cast<float>(range.min_disparity);
  variance_px2.create(measured_disparity_px.size());
  cv::parallel_for_(cv::Range(0, variance_px2.rows), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const float* disparity = measured_disparity_px[y];
      const uchar* ambiguous = ambiguity[y];
      float* variance = variance_px2[y];
      for (int x = 0; x < variance_px2.cols; ++x) {
        const float d = disparity[x];
        const float sigma = sigma_by_ambiguity[ambiguous[x]] + per_disparity * std::max(d, 0.0f);
        variance[x] = d >= smallest ? sigma * sigma : 0.0f;
      }
    }
  });
}

void publishedVariance(const cv::Mat1f& published_disparity_px, const DisparityState& state,
                       const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
                       const cv::Mat1f& measured_variance_px2, const DisparityRange& range,
                       const VarianceParams& params, cv::Mat1f& variance_px2) {
  const auto squared = [](double sigma_px) { return static_cast<float>(sigma_px * sigma_px); };
  const float unpredicted = squared(params.sigma_unpredicted_px);
  const float kept = squared(params.sigma_kept_px), filled = squared(params.sigma_filled_px);
  const float largest_innovation = static_cast<float>(params.max_innovation_px);
  const float innovation_weight = static_cast<float>(params.innovation_weight);
  const float smallest = static_cast<float>(range.min_disparity);
  variance_px2.create(published_disparity_px.size());
  cv::parallel_for_(cv::Range(0, variance_px2.rows), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const float* published = published_disparity_px[y];
      const float* filtered = state.disparity_px[y];
      const float* p = state.variance_px2[y];
      const float* predicted = prediction.disparity_px[y];
      const float* measured = measured_disparity_px[y];
      const float* measured_variance = measured_variance_px2[y];
      float* variance = variance_px2[y];
      for (int x = 0; x < variance_px2.cols; ++x) {
        const float innovation = std::min(std::abs(measured[x] - predicted[x]), largest_innovation);
        const float surprise =
            predicted[x] >= smallest ? innovation_weight * innovation * innovation : unpredicted;
        const float known = measured[x] >= smallest ? measured_variance[x] + surprise : p[x] + kept;
        const float any = filtered[x] >= smallest ? known : filled;
        variance[x] = published[x] >= smallest ? any : 0.0f;
      }
    }
  });
}

}  // namespace predictive_stereo
