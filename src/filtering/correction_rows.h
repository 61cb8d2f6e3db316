/// The loops of the correction over one row of pixels, see prediction_rows.h.
#pragma once

#include <cstdint>

namespace predictive_stereo {

struct CorrectionRow {
  const float* measured_px;
  const float* predicted_px;
  const float* predicted_variance_px2;
  const uint8_t* predicted_missed_frames;
  float* disparity_px;
  float* variance_px2;
  uint8_t* missed_frames;
};
struct CorrectionLimits {
  float smallest_valid, invalid;
  float r_px2;  ///< measurement noise
  float gate;   ///< squared, in standard deviations
  int max_missed_frames;
  uint8_t moving;  ///< see kMovesByItself
  float principal_offset_px;
};
void correctRow(const CorrectionRow& row, int width, const CorrectionLimits& limits);

/// Drops a prediction that correctRow() kept without a measurement, if the right image's row
/// matches a disparity more than kRefutingStep_px smaller on the line of sight to it.
/// @param nearest  scratch memory of width + kBesideNearest entries.
void dropRefuted(const CorrectionRow& row, int width, const CorrectionLimits& limits,
                 float* nearest);
constexpr float kRefutingStep_px = 3.0f;
constexpr int kBesideNearest = 2;

}  // namespace predictive_stereo
