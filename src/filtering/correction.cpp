#include "predictive_stereo/correction.h"

#include <limits>

#include "filtering/correction_rows.h"
#include "parallel/tasks.h"

namespace predictive_stereo {

void correct(const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
             const DisparityRange& range, const CorrectionParams& params, DisparityState& state,
             double principal_offset_px) {
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
  limits.moving = kMovesByItself;
  limits.principal_offset_px = static_cast<float>(principal_offset_px);
  parallelFor(cv::Range(0, size.height), [&](const cv::Range& part) {
    cv::AutoBuffer<float, 4096> nearest(static_cast<size_t>(size.width + kBesideNearest));
    for (int y = part.start; y < part.end; ++y) {
      const CorrectionRow row{measured_disparity_px[y],   prediction.disparity_px[y],
                              prediction.variance_px2[y], prediction.missed_frames[y],
                              state.disparity_px[y],      state.variance_px2[y],
                              state.missed_frames[y]};
      correctRow(row, size.width, limits);
      dropRefuted(row, size.width, limits, nearest.data());
    }
  });
}

}  // namespace predictive_stereo
