/// The loops of correction and variance over one row of pixels, see prediction_rows.h.
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
};
void correctRow(const CorrectionRow& row, int width, const CorrectionLimits& limits);

/// Drops what correctRow() kept without a measurement where the right image's row sees something
/// farther by more than kRefutingStep_px on the line of sight.
/// @param nearest  memory for width + kBesideNearest entries.
void dropRefuted(const CorrectionRow& row, int width, const CorrectionLimits& limits,
                 float* nearest);
constexpr float kRefutingStep_px = 3.0f;
constexpr int kBesideNearest = 2;

struct MeasurementTerms {
  float smallest_valid;
  float sigma_per_disparity;
  float sigma_by_ambiguity[256];
};
void measurementVarianceRow(const float* measured_px, const uint8_t* ambiguity, int width,
                            const MeasurementTerms& terms, float* variance_px2);

struct PublishedRow {
  const float* published_px;
  const float* filtered_px;
  const float* filtered_variance_px2;
  const float* predicted_px;
  const uint8_t* near_edge;  ///< of a predicted discontinuity
  const float* measured_px;
  const float* measured_variance_px2;
  float* variance_px2;
};
struct PublishedTerms {
  float smallest_valid;
  float unpredicted_px2, edge_px2, kept_px2, kept_edge_px2, filled_px2;
  float largest_innovation_px, innovation_weight;
};
void publishedVarianceRow(const PublishedRow& row, int width, const PublishedTerms& terms);

}  // namespace predictive_stereo
