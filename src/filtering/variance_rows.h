/// The loops of the variance over one row of pixels, see prediction_rows.h.
#pragma once

#include <cstdint>

namespace predictive_stereo {

struct MeasurementTerms {
  float smallest_valid;
  float variance_by_ambiguity_px2[256];
};
void measurementVarianceRow(const float* measured_px, const uint8_t* ambiguity, int width,
                            const MeasurementTerms& terms, float* variance_px2);

/// See countDisagreements.
/// @param above, below  the rows kDisagreementReachPx from `row`, those of the border beyond it.
constexpr int kDisagreementReachPx = 4;
void countDisagreementsOfRow(const float* above, const float* row, const float* below, int width,
                             float smallest_valid, uint8_t* count);

struct PublishedRow {
  const float* published_px;
  const uint8_t* disagreements;
  const float* filtered_px;
  const float* predicted_px;
  const float* measured_px;
  const float* measured_variance_px2;
  float* variance_px2;
};
struct PublishedTerms {
  float smallest_valid;
  float unpredicted_px2, kept_px2, filled_px2;
  float disagreement_px2;  ///< times the squared number of disagreements
  float largest_innovation_px, innovation_weight;
  float per_squared_disparity;
};
void publishedVarianceRow(const PublishedRow& row, int width, const PublishedTerms& terms);

/// Invalidates what is less certain than `largest_variance_px2`.
void dropUncertainInRow(int width, float largest_variance_px2, float invalid, float* disparity_px,
                        float* variance_px2);

}  // namespace predictive_stereo
