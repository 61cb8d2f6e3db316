#include "predictive_stereo/correction.h"

#include <algorithm>
#include <limits>
#include <opencv2/core/utility.hpp>

#include "filtering/correction_rows.h"

namespace predictive_stereo {
namespace {

constexpr float kRefutingStep_px = 3.0f;

// The nearest of the measured disparities that each pixel of the right image's row sees; `unseen`
// where there is none. `nearest` has one entry more than the row, for what lies outside of it.
void rightView(const float* measured_px, int width, float smallest_valid, float unseen,
               float* nearest) {
  std::fill_n(nearest, width + 1, unseen);
  for (int x = 0; x < width; ++x) {
    const float d = measured_px[x];
    const int column = static_cast<int>(static_cast<float>(x) - d + 0.5f);
    const bool inside = d >= smallest_valid && column >= 0 && column < width;
    float& seen = nearest[inside ? column : width];
    seen = std::max(seen, d);
  }
}

}  // namespace

void correct(const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
             const DisparityRange& range, const CorrectionParams& params, DisparityState& state) {
  const cv::Size size = measured_disparity_px.size();
  state.disparity_px.create(size);
  state.variance_px2.create(size);
  state.missed_frames.create(size);
  CorrectionLimits limits;
  limits.smallest_valid = static_cast<float>(range.min_disparity);
  limits.invalid = range.invalid();
  limits.r_px2 = static_cast<float>(params.measurement_noise_px2);
  limits.gate = params.gate_sigma > 0 ? static_cast<float>(params.gate_sigma * params.gate_sigma)
                                      : std::numeric_limits<float>::infinity();
  limits.max_missed_frames = params.max_missed_frames;
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      correctRow({measured_disparity_px[y], prediction.disparity_px[y], prediction.variance_px2[y],
                  prediction.missed_frames[y], state.disparity_px[y], state.variance_px2[y],
                  state.missed_frames[y]},
                 size.width, limits);
  });
}

void dropRefuted(const cv::Mat1f& measured_disparity_px, const DisparityRange& range,
                 DisparityState& state) {
  const int width = measured_disparity_px.cols;
  const auto smallest = static_cast<float>(range.min_disparity);
  cv::parallel_for_(cv::Range(0, measured_disparity_px.rows), [&](const cv::Range& part) {
    cv::AutoBuffer<float, 4096> buffer(static_cast<size_t>(width) + 1);
    float* nearest = buffer.data();
    for (int y = part.start; y < part.end; ++y) {
      const float* measured = measured_disparity_px[y];
      float* kept = state.disparity_px[y];
      rightView(measured, width, smallest, range.invalid(), nearest);
      for (int x = 0; x < width; ++x) {
        if (measured[x] >= smallest || kept[x] < smallest) continue;
        const int column = static_cast<int>(static_cast<float>(x) - kept[x] + 0.5f);
        if (column < 1 || column >= width - 1) continue;
        const float seen = std::max({nearest[column - 1], nearest[column], nearest[column + 1]});
        if (seen < smallest || seen >= kept[x] - kRefutingStep_px) continue;
        kept[x] = range.invalid();
        state.variance_px2(y, x) = 0;
        state.missed_frames(y, x) = 0;
      }
    }
  });
}

}  // namespace predictive_stereo
