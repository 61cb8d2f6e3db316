#include "predictive_stereo/correction.h"

#include <limits>

namespace predictive_stereo {
void correct(const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
             const DisparityRange& range, const CorrectionParams& params, DisparityState& state) {
  const cv::Size size = measured_disparity_px.size();
  state.disparity_px.create(size);
  state.variance_px2.create(size);
  state.missed_frames.create(size);
  const float r = static_cast<float>(params.measurement_noise_px2);
  const float invalid = range.invalid();
  const float smallest = static_cast<float>(range.min_disparity);
  const float gate = params.gate_sigma > 0
                         ? static_cast<float>(params.gate_sigma * params.gate_sigma)
                         : std::numeric_limits<float>::infinity();
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const float* measured = measured_disparity_px[y];
      const float* predicted = prediction.disparity_px[y];
      const float* predicted_variance = prediction.variance_px2[y];
      const uchar* predicted_missed = prediction.missed_frames[y];
      float* disparity = state.disparity_px[y];
      float* variance = state.variance_px2[y];
      uchar* missed = state.missed_frames[y];
      for (int x = 0; x < size.width; ++x) {
        const float z = measured[x], p = predicted_variance[x];
        const bool has_measurement = z >= smallest;
        const bool has_prediction = predicted[x] >= smallest;
        const float innovation = z - predicted[x];
        const bool agree = has_prediction & (innovation * innovation <= gate * (p + r));
        const float gain = agree ? p / (p + r) : 1.0f;
        const float rest = 1.0f - gain;
        const bool alive = has_prediction & (predicted_missed[x] < params.max_missed_frames);
        // Without prediction p is 0, and with gain 1 eq. 5 and 6 give the measurement and r.
        const float corrected = agree ? predicted[x] + gain * innovation : z;
        const float corrected_variance = rest * rest * p + gain * gain * r;
        disparity[x] = has_measurement ? corrected : alive ? predicted[x] : invalid;
        variance[x] = has_measurement ? corrected_variance : alive ? p : 0.0f;
        missed[x] = static_cast<uchar>(has_measurement ? 0 : alive ? predicted_missed[x] + 1 : 0);
      }
    }
  });
}

}  // namespace predictive_stereo
