#include "filtering/variance_rows.h"

#include <algorithm>

#include "simd/simd_dispatch.h"

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

// Unknown neighbours become NaN, for which every comparison is false.
template <class D>
HWY_INLINE hn::Vec<D> knownOrNan(D d, hn::Vec<D> disparity, hn::Vec<D> smallest) {
  return hn::Or(disparity, hn::VecFromMask(d, hn::Lt(disparity, smallest)));
}

// The count of countDisagreements at x, as floats. Of two opposite pixels, each one continues the
// surface if its disparity is similar; both do if the three are on one plane of any slope.
template <class D>
HWY_INLINE hn::Vec<D> disagreeing(D d, const DisagreementRows& rows, int left, int x, int right,
                                  hn::Vec<D> smallest) {
  const hn::RebindToSigned<D> di;
  const auto same_px = hn::Set(d, 2.5f), plane_px = hn::Set(d, 2.0f);
  const auto disparity = hn::LoadU(d, rows.centre + x);
  auto count = hn::Set(di, 8);
  const auto addOpposite = [&](const float* a, const float* b) HWY_ATTR {
    const auto rise_a = hn::Sub(knownOrNan(d, hn::LoadU(d, a), smallest), disparity);
    const auto rise_b = hn::Sub(knownOrNan(d, hn::LoadU(d, b), smallest), disparity);
    const auto plane = hn::Le(hn::Abs(hn::Add(rise_a, rise_b)), plane_px);
    const auto agrees_a = hn::Or(hn::Le(hn::Abs(rise_a), same_px), plane);
    const auto agrees_b = hn::Or(hn::Le(hn::Abs(rise_b), same_px), plane);
    count = hn::Add(count, hn::VecFromMask(di, hn::RebindMask(di, agrees_a)));
    count = hn::Add(count, hn::VecFromMask(di, hn::RebindMask(di, agrees_b)));
  };
  addOpposite(rows.above + left, rows.below + right);
  addOpposite(rows.above + x, rows.below + x);
  addOpposite(rows.above + right, rows.below + left);
  addOpposite(rows.centre + left, rows.centre + right);
  return hn::ConvertTo(d, count);
}

// Calls pixels(tag, x, columns of the left and right neighbour) for a whole row; in vectors where
// these and their neighbours are inside the row.
template <class Pixels>
HWY_INLINE void forPixelsWithNeighbours(int width, const Pixels& pixels) {
  const hn::ScalableTag<float> vectors;
  const hn::FixedTag<float, 1> one;
  const int lanes = static_cast<int>(hn::Lanes(vectors)), reach = kDisagreementReachPx;
  int x = 0;
  for (; x < std::min(reach, width); ++x) pixels(one, 0, x, std::min(x + reach, width - 1));
  for (; x + lanes + reach <= width; x += lanes) pixels(vectors, x - reach, x, x + reach);
  for (; x < width; ++x) pixels(one, x - reach, x, std::min(x + reach, width - 1));
}

void countDisagreementsOfRow(const DisagreementRows& rows, int width, float smallest_valid,
                             uint8_t* count) {
  forPixelsWithNeighbours(width, [&](auto d, int left, int x, int right) HWY_ATTR {
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<uint8_t, decltype(d)> d8;
    const auto strangers = disagreeing(d, rows, left, x, right, hn::Set(d, smallest_valid));
    hn::StoreU(hn::DemoteTo(d8, hn::ConvertTo(di, strangers)), d8, count + x);
  });
}

void publishRow(const PublishedRow& row, int width, const PublishedTerms& terms) {
  forPixelsWithNeighbours(width, [&](auto d, int left, int x, int right) HWY_ATTR {
    const auto smallest = hn::Set(d, terms.smallest_valid);
    const auto strangers = disagreeing(d, row.disparity_px, left, x, right, smallest);
    const auto disparity = hn::LoadU(d, row.disparity_px.centre + x);
    const auto filtered = hn::LoadU(d, row.filtered_px + x);
    const auto predicted = hn::LoadU(d, row.predicted_px + x);
    const auto measured = hn::LoadU(d, row.measured_px + x);
    const auto of_match = hn::LoadU(d, row.measured_variance_px2 + x);

    const auto innovation =
        hn::Min(hn::Abs(hn::Sub(measured, predicted)), hn::Set(d, terms.largest_innovation_px));
    const auto surprise = hn::IfThenElse(
        hn::Ge(predicted, smallest),
        hn::Mul(hn::Mul(hn::Set(d, terms.innovation_weight), innovation), innovation),
        hn::Set(d, terms.unpredicted_px2));
    const auto of_filtered = hn::IfThenElse(hn::Ge(measured, smallest), hn::Add(of_match, surprise),
                                            hn::Set(d, terms.kept_px2));
    const auto of_any =
        hn::IfThenElse(hn::Ge(filtered, smallest), of_filtered, hn::Set(d, terms.filled_px2));
    const auto of_surroundings =
        hn::Mul(hn::Mul(hn::Set(d, terms.disagreement_px2), strangers), strangers);
    const auto of_rectification =
        hn::Mul(hn::Mul(hn::Set(d, terms.per_squared_disparity), disparity), disparity);
    const auto nearness =
        hn::Mul(hn::Max(disparity, hn::Zero(d)), hn::Set(d, terms.per_far_disparity));
    const auto far = hn::Div(hn::Set(d, terms.far_px), hn::Add(hn::Set(d, 1.0f), nearness));
    const auto of_distance = hn::Mul(far, far);
    const auto variance =
        hn::Add(hn::Add(of_any, of_surroundings), hn::Add(of_distance, of_rectification));

    const auto certain = hn::And(hn::Ge(disparity, smallest),
                                 hn::Le(variance, hn::Set(d, terms.largest_variance_px2)));
    hn::StoreU(hn::IfThenElse(certain, disparity, hn::Set(d, terms.invalid)), d,
               row.published_px + x);
    hn::StoreU(hn::IfThenElseZero(certain, variance), d, row.variance_px2 + x);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(measurementVarianceRow);
HWY_EXPORT(countDisagreementsOfRow);
HWY_EXPORT(publishRow);

void measurementVarianceRow(const float* measured_px, const uint8_t* ambiguity, int width,
                            const MeasurementTerms& terms, float* variance_px2) {
  HWY_DYNAMIC_DISPATCH(measurementVarianceRow)
  (measured_px, ambiguity, width, terms, variance_px2);
}

void countDisagreementsOfRow(const DisagreementRows& rows, int width, float smallest_valid,
                             uint8_t* count) {
  HWY_DYNAMIC_DISPATCH(countDisagreementsOfRow)(rows, width, smallest_valid, count);
}

void publishRow(const PublishedRow& row, int width, const PublishedTerms& terms) {
  HWY_DYNAMIC_DISPATCH(publishRow)(row, width, terms);
}

}  // namespace predictive_stereo
#endif
