#include "filtering/variance_rows.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/variance_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class D>
HWY_INLINE int measurementVariancePixels(D d, const float* measured, const uint8_t* ambiguity,
                                         int width, const MeasurementTerms& terms, int x,
                                         float* variance) {
  const hn::RebindToSigned<D> di;
  const hn::Rebind<uint8_t, D> d8;
  const auto smallest = hn::Set(d, terms.smallest_valid);
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (; x + lanes <= width; x += lanes) {
    const auto valid = hn::Ge(hn::LoadU(d, measured + x), smallest);
    const auto ambiguous = hn::PromoteTo(di, hn::LoadU(d8, ambiguity + x));
    const auto of_match = hn::GatherIndex(d, terms.variance_by_ambiguity_px2, ambiguous);
    hn::StoreU(hn::IfThenElseZero(valid, of_match), d, variance + x);
  }
  return x;
}

void measurementVarianceRow(const float* measured_px, const uint8_t* ambiguity, int width,
                            const MeasurementTerms& terms, float* variance_px2) {
  const int x = measurementVariancePixels(hn::ScalableTag<float>(), measured_px, ambiguity, width,
                                          terms, 0, variance_px2);
  measurementVariancePixels(hn::FixedTag<float, 1>(), measured_px, ambiguity, width, terms, x,
                            variance_px2);
}

// Two opposite pixels around one of disparity d: how many of them do not continue its surface. They
// do where they are about as near, or where the three lie on one plane, however steep.
HWY_INLINE int disagreeing(float a, float b, float d, float smallest) {
  constexpr float kSame_px = 2.5f, kPlane_px = 2.0f;
  const int known_a = a >= smallest, known_b = b >= smallest;
  const int same_a = known_a & (std::abs(a - d) <= kSame_px);
  const int same_b = known_b & (std::abs(b - d) <= kSame_px);
  const int plane = known_a & known_b & (std::abs((a - d) + (b - d)) <= kPlane_px);
  return 2 - (same_a | plane) - (same_b | plane);
}

HWY_INLINE int disagreeingAround(const float* above, const float* row, const float* below, int left,
                                 int x, int right, float smallest) {
  const float d = row[x];
  return disagreeing(above[left], below[right], d, smallest) +
         disagreeing(above[x], below[x], d, smallest) +
         disagreeing(above[right], below[left], d, smallest) +
         disagreeing(row[left], row[right], d, smallest);
}

HWY_NOINLINE void countInside(const float* HWY_RESTRICT above, const float* HWY_RESTRICT row,
                              const float* HWY_RESTRICT below, int first, int last, float smallest,
                              uint8_t* HWY_RESTRICT count) {
  for (int x = first; x < last; ++x)
    count[x] = static_cast<uint8_t>(disagreeingAround(above, row, below, x - kDisagreementReachPx,
                                                      x, x + kDisagreementReachPx, smallest));
}

void countDisagreementsOfRow(const float* above, const float* row, const float* below, int width,
                             float smallest_valid, uint8_t* count) {
  const int first = std::min(kDisagreementReachPx, width);
  const int last = std::max(width - kDisagreementReachPx, first);
  countInside(above, row, below, first, last, smallest_valid, count);
  for (int x = 0; x < width; x = x + 1 == first ? last : x + 1)
    count[x] = static_cast<uint8_t>(
        disagreeingAround(above, row, below, std::max(x - kDisagreementReachPx, 0), x,
                          std::min(x + kDisagreementReachPx, width - 1), smallest_valid));
}

// Arguments that are known not to overlap are passed one by one: only then do compilers vectorise.
HWY_NOINLINE void publishedVariancePixels(const float* HWY_RESTRICT published,
                                          const uint8_t* HWY_RESTRICT disagreements,
                                          const float* HWY_RESTRICT filtered,
                                          const float* HWY_RESTRICT predicted,
                                          const float* HWY_RESTRICT measured,
                                          const float* HWY_RESTRICT measured_variance, int width,
                                          PublishedTerms terms, float* HWY_RESTRICT variance) {
  const float smallest = terms.smallest_valid;
  for (int x = 0; x < width; ++x) {
    const float d = published[x], strangers = disagreements[x];
    const float innovation =
        std::min(std::abs(measured[x] - predicted[x]), terms.largest_innovation_px);
    const float surprise = predicted[x] >= smallest
                               ? terms.innovation_weight * innovation * innovation
                               : terms.unpredicted_px2;
    const float matched = measured_variance[x] + surprise;
    const float known = measured[x] >= smallest ? matched : terms.kept_px2;
    const float any = filtered[x] >= smallest ? known : terms.filled_px2;
    const float all =
        any + terms.disagreement_px2 * strangers * strangers + terms.per_squared_disparity * d * d;
    variance[x] = d >= smallest ? all : 0.0f;
  }
}

void publishedVarianceRow(const PublishedRow& row, int width, const PublishedTerms& terms) {
  publishedVariancePixels(row.published_px, row.disagreements, row.filtered_px, row.predicted_px,
                          row.measured_px, row.measured_variance_px2, width, terms,
                          row.variance_px2);
}

HWY_NOINLINE void dropUncertainInRow(int width, float largest_variance_px2, float invalid,
                                     float* HWY_RESTRICT disparity_px,
                                     float* HWY_RESTRICT variance_px2) {
  for (int x = 0; x < width; ++x) {
    const bool certain = variance_px2[x] <= largest_variance_px2;
    disparity_px[x] = certain ? disparity_px[x] : invalid;
    variance_px2[x] = certain ? variance_px2[x] : 0.0f;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(measurementVarianceRow);
HWY_EXPORT(countDisagreementsOfRow);
HWY_EXPORT(publishedVarianceRow);
HWY_EXPORT(dropUncertainInRow);

void measurementVarianceRow(const float* measured_px, const uint8_t* ambiguity, int width,
                            const MeasurementTerms& terms, float* variance_px2) {
  HWY_DYNAMIC_DISPATCH(measurementVarianceRow)
  (measured_px, ambiguity, width, terms, variance_px2);
}

void countDisagreementsOfRow(const float* above, const float* row, const float* below, int width,
                             float smallest_valid, uint8_t* count) {
  HWY_DYNAMIC_DISPATCH(countDisagreementsOfRow)(above, row, below, width, smallest_valid, count);
}

void publishedVarianceRow(const PublishedRow& row, int width, const PublishedTerms& terms) {
  HWY_DYNAMIC_DISPATCH(publishedVarianceRow)(row, width, terms);
}

void dropUncertainInRow(int width, float largest_variance_px2, float invalid, float* disparity_px,
                        float* variance_px2) {
  HWY_DYNAMIC_DISPATCH(dropUncertainInRow)
  (width, largest_variance_px2, invalid, disparity_px, variance_px2);
}

}  // namespace predictive_stereo
#endif
