#include "predictive_stereo/variance.h"

#include <algorithm>
#include <array>

namespace predictive_stereo {

void measurementVariance(const cv::Mat1f& measured_disparity_px, const cv::Mat1b& ambiguity,
                         const DisparityRange& range, const MeasurementNoiseParams& params,
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

void filteredVariance(const cv::Mat1f& published_disparity_px, const DisparityState& state,
                      const cv::Mat1f& measured_variance_px2, const DisparityRange& range,
                      double measurement_noise_px2, cv::Mat1f& variance_px2) {
  constexpr float kFilledVariancePx2 = 2.0f;
  const float per_r = static_cast<float>(1.0 / measurement_noise_px2);
  const float smallest = static_cast<float>(range.min_disparity);
  variance_px2.create(measured_variance_px2.size());
  cv::parallel_for_(cv::Range(0, variance_px2.rows), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const float* published = published_disparity_px[y];
      const float* filtered = state.disparity_px[y];
      const float* p = state.variance_px2[y];
      const float* measured = measured_variance_px2[y];
      float* variance = variance_px2[y];
      for (int x = 0; x < variance_px2.cols; ++x) {
        const float known = measured[x] > 0.0f ? measured[x] * p[x] * per_r : p[x];
        const float any = filtered[x] >= smallest ? known : kFilledVariancePx2;
        variance[x] = published[x] >= smallest ? any : 0.0f;
      }
    }
  });
}

}  // namespace predictive_stereo
