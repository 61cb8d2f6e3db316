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

// The columns of a pixel and of its neighbours in each ring.
struct Columns {
  int left[kDisagreementRings], x, right[kDisagreementRings];
};

// The disagreement of measureDisagreement at x.
template <class D>
HWY_INLINE hn::Vec<D> disagreeing(D d, const DisagreementRows& rows, const Columns& columns,
                                  hn::Vec<D> smallest) {
  const int x = columns.x;
  const auto largest_px = hn::Set(d, kLargestBendPx);
  const auto disparity = hn::LoadU(d, rows.centre + x);
  auto sum_px = hn::Zero(d);
  const auto addOpposite = [&](const float* a, const float* b) HWY_ATTR {
    const auto rise_a = hn::Sub(knownOrNan(d, hn::LoadU(d, a), smallest), disparity);
    const auto rise_b = hn::Sub(knownOrNan(d, hn::LoadU(d, b), smallest), disparity);
    const auto bend_px = hn::Abs(hn::Add(rise_a, rise_b));
    const auto known_and_less = hn::Lt(bend_px, largest_px);
    sum_px = hn::Add(sum_px, hn::IfThenElse(known_and_less, bend_px, largest_px));
  };
  for (int ring = 0; ring < kDisagreementRings; ++ring) {
    const float *above = rows.above[ring], *below = rows.below[ring];
    const int left = columns.left[ring], right = columns.right[ring];
    addOpposite(above + left, below + right);
    addOpposite(above + x, below + x);
    addOpposite(above + right, below + left);
    addOpposite(rows.centre + left, rows.centre + right);
  }
  return hn::Mul(sum_px, hn::Set(d, 1.0f / kLargestBendPx));
}

// Calls pixels(tag, columns) for a whole row; in vectors where these and their neighbours are
// inside the row.
template <class Pixels>
HWY_INLINE void forPixelsWithNeighbours(int width, const Pixels& pixels) {
  const hn::ScalableTag<float> vectors;
  const hn::FixedTag<float, 1> one;
  const int lanes = static_cast<int>(hn::Lanes(vectors));
  const int reach = kDisagreementReachPx[kDisagreementRings - 1];
  const auto around = [width](int x) {
    Columns columns;
    columns.x = x;
    for (int ring = 0; ring < kDisagreementRings; ++ring) {
      columns.left[ring] = std::max(x - kDisagreementReachPx[ring], 0);
      columns.right[ring] = std::min(x + kDisagreementReachPx[ring], width - 1);
    }
    return columns;
  };
  int x = 0;
  for (; x < std::min(reach, width); ++x) pixels(one, around(x));
  for (; x + lanes + reach <= width; x += lanes) pixels(vectors, around(x));
  for (; x < width; ++x) pixels(one, around(x));
}

void measureDisagreementOfRow(const DisagreementRows& rows, int width, float smallest_valid,
                              float* disagreement) {
  forPixelsWithNeighbours(width, [&](auto d, const Columns& columns) HWY_ATTR {
    hn::StoreU(disagreeing(d, rows, columns, hn::Set(d, smallest_valid)), d,
               disagreement + columns.x);
  });
}

void publishRow(const PublishedRow& row, int width, const PublishedTerms& terms) {
  forPixelsWithNeighbours(width, [&](auto d, const Columns& columns) HWY_ATTR {
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<uint8_t, decltype(d)> d8;
    const int x = columns.x;
    const auto smallest = hn::Set(d, terms.smallest_valid);
    const auto disagreement = disagreeing(d, row.disparity_px, columns, smallest);
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
    const auto byte = hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d8, row.ambiguity + x)));
    const auto ambiguity = hn::IfThenElse(hn::Ge(measured, smallest),
                                          hn::Mul(byte, hn::Set(d, 1.0f / 255)), hn::Set(d, 1.0f));
    const auto alone = hn::And(hn::Ge(measured, smallest), hn::Lt(predicted, smallest));
    const auto doubt =
        hn::Add(hn::Add(hn::Set(d, 1.0f),
                        hn::Mul(hn::Mul(hn::Set(d, terms.ambiguity_weight), ambiguity), ambiguity)),
                hn::IfThenElseZero(alone, hn::Set(d, terms.unpredicted_weight)));
    const auto around = hn::Mul(hn::Mul(hn::Set(d, terms.disagreement_px), disagreement), doubt);
    const auto of_surroundings = hn::Mul(around, around);
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
HWY_EXPORT(measureDisagreementOfRow);
HWY_EXPORT(publishRow);

void measurementVarianceRow(const float* measured_px, const uint8_t* ambiguity, int width,
                            const MeasurementTerms& terms, float* variance_px2) {
  HWY_DYNAMIC_DISPATCH(measurementVarianceRow)
  (measured_px, ambiguity, width, terms, variance_px2);
}

void measureDisagreementOfRow(const DisagreementRows& rows, int width, float smallest_valid,
                              float* disagreement) {
  HWY_DYNAMIC_DISPATCH(measureDisagreementOfRow)(rows, width, smallest_valid, disagreement);
}

void publishRow(const PublishedRow& row, int width, const PublishedTerms& terms) {
  HWY_DYNAMIC_DISPATCH(publishRow)(row, width, terms);
}

}  // namespace predictive_stereo
#endif
