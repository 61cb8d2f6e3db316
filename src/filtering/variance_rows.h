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

/// A row and the rows kDisagreementReachPx above and below it, or the image's first and last row if
/// these are outside.
struct DisagreementRows {
  const float* above;
  const float* centre;
  const float* below;
};
constexpr int kDisagreementReachPx = 4;
/// See countDisagreements.
void countDisagreementsOfRow(const DisagreementRows& rows, int width, float smallest_valid,
                             uint8_t* count);

struct PublishedRow {
  DisagreementRows disparity_px;
  const float* filtered_px;
  const float* predicted_px;
  const float* measured_px;
  const float* measured_variance_px2;
  float* published_px;
  float* variance_px2;
};
struct PublishedTerms {
  float smallest_valid, invalid;
  float unpredicted_px2, kept_px2, filled_px2;
  float disagreement_px2;  ///< times the squared number of disagreements
  float largest_innovation_px, innovation_weight;
  float far_px, per_far_disparity;
  float per_squared_disparity;
  float largest_variance_px2;  ///< of published pixels
};
/// See publish.
void publishRow(const PublishedRow& row, int width, const PublishedTerms& terms);

}  // namespace predictive_stereo
