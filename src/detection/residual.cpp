#include "predictive_stereo/residual.h"

#include <algorithm>
#include <cmath>

#include "parallel/tasks.h"

namespace predictive_stereo {

void normalizedResidual(const cv::Mat1f& measured_disparity_px,
                        const cv::Mat1f& measured_variance_px2,
                        const cv::Mat1f& predicted_disparity_px,
                        const cv::Mat1f& predicted_variance_px2, const DisparityRange& range,
                        cv::Mat1f& residual) {
  residual.create(measured_disparity_px.size());
  const auto smallest = static_cast<float>(range.min_disparity);
  parallelForEach(residual.rows, [&](int y) {
    const float* measured = measured_disparity_px[y];
    const float* predicted = predicted_disparity_px[y];
    const float* measured_variance = measured_variance_px2[y];
    const float* predicted_variance = predicted_variance_px2[y];
    float* out = residual[y];
    for (int x = 0; x < residual.cols; ++x) {
      const float variance = std::max(measured_variance[x] + predicted_variance[x], 1e-6f);
      const float z = (measured[x] - predicted[x]) / std::sqrt(variance);
      const float cut = std::min(std::max(z, -kLargestResidual), kLargestResidual);
      out[x] = std::min(measured[x], predicted[x]) >= smallest ? cut : 0.0f;
    }
  });
}

void absoluteDifference(const cv::Mat1f& measured_disparity_px,
                        const cv::Mat1f& predicted_disparity_px, const DisparityRange& range,
                        float largest_px, cv::Mat1f& difference_px) {
  const int smallest = range.min_disparity;
  const cv::Mat1b known =
      (measured_disparity_px >= smallest) & (predicted_disparity_px >= smallest);
  cv::absdiff(measured_disparity_px, predicted_disparity_px, difference_px);
  cv::min(difference_px, largest_px, difference_px);
  difference_px.setTo(0, ~known);
}

}  // namespace predictive_stereo
