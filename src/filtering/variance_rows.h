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

/// Neighbours in two rings: the inner one sees specks, the outer one whole regions that are wrong.
constexpr int kDisagreementRings = 2;
constexpr int kDisagreementReachPx[kDisagreementRings] = {4, 9};
constexpr float kLargestBendPx = 4.0f;
/// A row and, for each ring, the rows above and below it, or the image's first and last row if
/// these are outside.
struct DisagreementRows {
  const float* centre;
  const float* above[kDisagreementRings];
  const float* below[kDisagreementRings];
};
/// See measureDisagreement.
void measureDisagreementOfRow(const DisagreementRows& rows, int width, float smallest_valid,
                              float* disagreement);

struct PublishedRow {
  DisagreementRows disparity_px;
  const float* filtered_px;
  const float* predicted_px;
  const float* measured_px;
  const float* measured_variance_px2;
  const uint8_t* ambiguity;
  float* published_px;
  float* variance_px2;
};
struct PublishedTerms {
  float smallest_valid, invalid;
  float unpredicted_px2, kept_px2, filled_px2;
  float disagreement_px, ambiguity_weight, unpredicted_weight;
  float largest_innovation_px, innovation_weight;
  float far_px, per_far_disparity;
  float per_squared_disparity;
  float largest_variance_px2;  ///< of published pixels
};
/// See publish.
void publishRow(const PublishedRow& row, int width, const PublishedTerms& terms);

}  // namespace predictive_stereo
