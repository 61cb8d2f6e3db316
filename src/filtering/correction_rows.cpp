#include "filtering/correction_rows.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/correction_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Arguments that are known not to overlap are passed one by one: only then do compilers vectorise.
HWY_NOINLINE void correctPixels(const float* HWY_RESTRICT measured,
                                const float* HWY_RESTRICT predicted,
                                const float* HWY_RESTRICT predicted_variance,
                                const uint8_t* HWY_RESTRICT predicted_missed, int width,
                                CorrectionLimits limits, float* HWY_RESTRICT disparity,
                                float* HWY_RESTRICT variance, uint8_t* HWY_RESTRICT missed) {
  const float r = limits.r_px2, smallest = limits.smallest_valid;
  for (int x = 0; x < width; ++x) {
    const float z = measured[x], p = predicted_variance[x];
    const float innovation = z - predicted[x];
    const bool agree =
        (predicted[x] >= smallest) & (innovation * innovation <= limits.gate * (p + r));
    const float kalman_gain = p / (p + r);
    const float gain = agree ? kalman_gain : 1.0f;
    const float rest = 1.0f - gain;
    const bool alive =
        (predicted[x] >= smallest) & (predicted_missed[x] < limits.max_missed_frames);
    // eq. 5 and 6; with gain 1 they give the measurement and r.
    const float fused = predicted[x] + gain * innovation;
    const float corrected = agree ? fused : z;
    const float corrected_variance = rest * rest * p + gain * gain * r;
    const float kept = alive ? predicted[x] : limits.invalid;
    const float kept_variance = alive ? p : 0.0f;
    disparity[x] = z >= smallest ? corrected : kept;
    variance[x] = z >= smallest ? corrected_variance : kept_variance;
  }
  for (int x = 0; x < width; ++x) {
    const uint8_t kept = (measured[x] < smallest) & (predicted[x] >= smallest) ? 255 : 0;
    const uint8_t alive = predicted_missed[x] < limits.max_missed_frames ? 255 : 0;
    missed[x] = static_cast<uint8_t>((predicted_missed[x] + 1) & kept & alive);
  }
}

void correctRow(const CorrectionRow& row, int width, const CorrectionLimits& limits) {
  correctPixels(row.measured_px, row.predicted_px, row.predicted_variance_px2,
                row.predicted_missed_frames, width, limits, row.disparity_px, row.variance_px2,
                row.missed_frames);
}

template <class D>
HWY_INLINE int measurementVariancePixels(D d, const float* measured, const uint8_t* ambiguity,
                                         int width, const MeasurementTerms& terms, int x,
                                         float* variance) {
  const hn::RebindToSigned<D> di;
  const hn::Rebind<uint8_t, D> d8;
  const auto per_disparity = hn::Set(d, terms.sigma_per_disparity);
  const auto smallest = hn::Set(d, terms.smallest_valid);
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (; x + lanes <= width; x += lanes) {
    const auto disparity = hn::LoadU(d, measured + x);
    const auto ambiguous = hn::PromoteTo(di, hn::LoadU(d8, ambiguity + x));
    const auto by_disparity = hn::Mul(per_disparity, hn::Max(disparity, hn::Zero(d)));
    const auto sigma =
        hn::Add(hn::GatherIndex(d, terms.sigma_by_ambiguity, ambiguous), by_disparity);
    const auto squared = hn::Mul(sigma, sigma);
    hn::StoreU(hn::IfThenElseZero(hn::Ge(disparity, smallest), squared), d, variance + x);
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

HWY_NOINLINE void publishedVariancePixels(const float* HWY_RESTRICT published,
                                          const float* HWY_RESTRICT filtered,
                                          const float* HWY_RESTRICT filtered_variance,
                                          const float* HWY_RESTRICT predicted,
                                          const uint8_t* HWY_RESTRICT near_edge,
                                          const float* HWY_RESTRICT measured,
                                          const float* HWY_RESTRICT measured_variance, int width,
                                          PublishedTerms terms, float* HWY_RESTRICT variance) {
  const float smallest = terms.smallest_valid;
  for (int x = 0; x < width; ++x) {
    const float innovation =
        std::min(std::abs(measured[x] - predicted[x]), terms.largest_innovation_px);
    const bool edge = near_edge[x] != 0;
    const float at_edge = edge ? terms.edge_px2 : 0.0f;
    const float surprise = predicted[x] >= smallest
                               ? terms.innovation_weight * innovation * innovation + at_edge
                               : terms.unpredicted_px2;
    const float matched = measured_variance[x] + surprise;
    // Near a discontinuity the filter's variance is that of no knowledge at all.
    const float kept_variance = filtered_variance[x] + terms.kept_px2;
    const float kept = edge ? terms.kept_edge_px2 : kept_variance;
    const float known = measured[x] >= smallest ? matched : kept;
    const float any = filtered[x] >= smallest ? known : terms.filled_px2;
    variance[x] = published[x] >= smallest ? any : 0.0f;
  }
}

void publishedVarianceRow(const PublishedRow& row, int width, const PublishedTerms& terms) {
  publishedVariancePixels(row.published_px, row.filtered_px, row.filtered_variance_px2,
                          row.predicted_px, row.near_edge, row.measured_px,
                          row.measured_variance_px2, width, terms, row.variance_px2);
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(correctRow);
HWY_EXPORT(measurementVarianceRow);
HWY_EXPORT(publishedVarianceRow);

void correctRow(const CorrectionRow& row, int width, const CorrectionLimits& limits) {
  HWY_DYNAMIC_DISPATCH(correctRow)(row, width, limits);
}

void measurementVarianceRow(const float* measured_px, const uint8_t* ambiguity, int width,
                            const MeasurementTerms& terms, float* variance_px2) {
  HWY_DYNAMIC_DISPATCH(measurementVarianceRow)
  (measured_px, ambiguity, width, terms, variance_px2);
}

void publishedVarianceRow(const PublishedRow& row, int width, const PublishedTerms& terms) {
  HWY_DYNAMIC_DISPATCH(publishedVarianceRow)(row, width, terms);
}

}  // namespace predictive_stereo
#endif
