#include "predictive_stereo/variance.h"

#include <algorithm>
#include <limits>

#include "filtering/create_apart.h"
#include "parallel/tasks.h"
#include "predictive_stereo/photometric_residual.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/variance.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "simd/pixel_loop-inl.h"

#ifndef PREDICTIVE_STEREO_VARIANCE_ROW
#define PREDICTIVE_STEREO_VARIANCE_ROW
namespace predictive_stereo {

struct MeasurementTerms {
  float smallest_valid;
  float variance_by_ambiguity_px2[256];
};

/// Neighbours in two rings: the inner one sees specks, the outer one whole regions that are wrong.
constexpr int kDisagreementRings = 2;
constexpr int kDisagreementReachPx[kDisagreementRings] = {4, 9};
constexpr float kLargestBendPx = 4.0f;
constexpr int kResidualShift = 2;  ///< of a column, to that of its residual
static_assert(kResidualStep == 1 << kResidualShift);
/// A row and, for each ring, the rows above and below it: as far as the ring reaches, or both as
/// far as the nearer border of the image.
struct DisagreementRows {
  const float* centre;
  const float* above[kDisagreementRings];
  const float* below[kDisagreementRings];
  float per_rise;  ///< one over the rows from the inner ring's row above to that below; 0: the same
};

struct PublishedRow {
  DisagreementRows disparity_px;
  const float* unfilled_px;
  const float* predicted_px;
  const float* measured_px;
  const float* measured_variance_px2;
  const uint8_t* ambiguity;
  const float* residual_share;
  float* published_px;
  float* variance_px2;
};
struct PublishedTerms {
  float smallest_valid, invalid;
  float unpredicted_px2, kept_px2, filled_px2;
  float disagreement_px, ambiguity_weight, unpredicted_weight, residual_weight;
  float per_squared_disparity;
  float slope_weight;
  float largest_variance_px2;  ///< of published pixels
};

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

void measurementVarianceRow(const float* measured_px, const uint8_t* ambiguity, int width,
                            const MeasurementTerms& terms, float* variance_px2) {
  forPixels<float>(0, width, [&](auto d, int x) HWY_ATTR {
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<uint8_t, decltype(d)> d8;
    const auto valid = hn::Ge(hn::LoadU(d, measured_px + x), hn::Set(d, terms.smallest_valid));
    const auto ambiguous = hn::PromoteTo(di, hn::LoadU(d8, ambiguity + x));
    const auto of_match = hn::GatherIndex(d, terms.variance_by_ambiguity_px2, ambiguous);
    hn::StoreU(hn::IfThenElseZero(valid, of_match), d, variance_px2 + x);
  });
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

// The disagreement of the surroundings (see VarianceParams) at x.
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
      const int reach = std::min({kDisagreementReachPx[ring], x, width - 1 - x});
      columns.left[ring] = x - reach;
      columns.right[ring] = x + reach;
    }
    return columns;
  };
  int x = 0;
  for (; x < std::min(reach, width); ++x) pixels(one, around(x));
  for (; x + lanes + reach <= width; x += lanes) pixels(vectors, around(x));
  for (; x < width; ++x) pixels(one, around(x));
}

// How far the effect of disagreement grows with what speaks against the match.
template <class D>
HWY_INLINE hn::Vec<D> doubtAt(D d, const PublishedRow& row, const PublishedTerms& terms, int x,
                              hn::Mask<D> is_measured, hn::Mask<D> alone) {
  const hn::RebindToSigned<D> di;
  const hn::Rebind<uint8_t, D> d8;
  const auto one = hn::Set(d, 1.0f);
  const auto byte = hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d8, row.ambiguity + x)));
  const auto ambiguity = hn::IfThenElse(is_measured, hn::Mul(byte, hn::Set(d, 1.0f / 255)), one);
  const auto of_match = hn::Mul(hn::Mul(hn::Set(d, terms.ambiguity_weight), ambiguity), ambiguity);
  const auto of_past = hn::IfThenElseZero(alone, hn::Set(d, terms.unpredicted_weight));
  const auto share =
      hn::GatherIndex(d, row.residual_share, hn::ShiftRight<kResidualShift>(hn::Iota(di, x)));
  const auto of_images = hn::Mul(hn::Set(d, terms.residual_weight), share);
  return hn::Mul(hn::Add(hn::Add(one, of_match), of_past), hn::Add(one, of_images));
}

// By how much sigma is smaller on a surface whose disparities grow downwards.
template <class D>
HWY_INLINE hn::Vec<D> steepnessAt(D d, const DisagreementRows& rows, int x, hn::Vec<D> smallest,
                                  float slope_weight) {
  const auto above = hn::LoadU(d, rows.above[0] + x), below = hn::LoadU(d, rows.below[0] + x);
  const auto rises = hn::And(hn::Ge(above, smallest), hn::Gt(below, above));
  const auto rise = hn::IfThenElseZero(rises, hn::Sub(below, above));
  return hn::Add(hn::Set(d, 1.0f), hn::Mul(hn::Set(d, slope_weight * rows.per_rise), rise));
}

void publishRow(const PublishedRow& row, int width, const PublishedTerms& terms) {
  forPixelsWithNeighbours(width, [&](auto d, const Columns& columns) HWY_ATTR {
    const int x = columns.x;
    const auto smallest = hn::Set(d, terms.smallest_valid);
    const auto disparity = hn::LoadU(d, row.disparity_px.centre + x);
    const auto is_measured = hn::Ge(hn::LoadU(d, row.measured_px + x), smallest);
    const auto alone = hn::And(is_measured, hn::Lt(hn::LoadU(d, row.predicted_px + x), smallest));
    const auto of_match = hn::LoadU(d, row.measured_variance_px2 + x);

    const auto of_filtered =
        hn::Add(hn::IfThenElse(is_measured, of_match, hn::Set(d, terms.kept_px2)),
                hn::IfThenElseZero(alone, hn::Set(d, terms.unpredicted_px2)));
    const auto is_filled = hn::Lt(hn::LoadU(d, row.unfilled_px + x), smallest);
    const auto of_any = hn::IfThenElse(is_filled, hn::Set(d, terms.filled_px2), of_filtered);
    const auto disagreement = disagreeing(d, row.disparity_px, columns, smallest);
    const auto around = hn::Mul(hn::Mul(hn::Set(d, terms.disagreement_px), disagreement),
                                doubtAt(d, row, terms, x, is_measured, alone));
    const auto of_surroundings = hn::Mul(around, around);
    const auto of_rectification =
        hn::Mul(hn::Mul(hn::Set(d, terms.per_squared_disparity), disparity), disparity);
    const auto upright = hn::Add(hn::Add(of_any, of_surroundings), of_rectification);
    const auto steepness = steepnessAt(d, row.disparity_px, x, smallest, terms.slope_weight);
    const auto variance = hn::Div(upright, hn::Mul(steepness, steepness));

    const auto certain = hn::And(hn::Ge(disparity, smallest),
                                 hn::Le(variance, hn::Set(d, terms.largest_variance_px2)));
    hn::StoreU(hn::IfThenElse(certain, disparity, hn::Set(d, terms.invalid)), d,
               row.published_px + x);
    hn::StoreU(hn::IfThenElseZero(certain, variance), d, row.variance_px2 + x);
  });
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(measurementVarianceRow);
HWY_EXPORT(publishRow);

DisagreementRows rowsAround(const cv::Mat1f& disparity_px, int y) {
  DisagreementRows rows;
  rows.centre = disparity_px[y];
  for (int ring = 0; ring < kDisagreementRings; ++ring) {
    const int reach = std::min({kDisagreementReachPx[ring], y, disparity_px.rows - 1 - y});
    rows.above[ring] = disparity_px[y - reach];
    rows.below[ring] = disparity_px[y + reach];
    if (ring == 0) rows.per_rise = reach > 0 ? 0.5f / static_cast<float>(reach) : 0;
  }
  return rows;
}

}  // namespace

void measurementVariance(const cv::Mat1f& measured_disparity_px, const cv::Mat1b& ambiguity,
                         const DisparityRange& range, const VarianceParams& params,
                         cv::Mat1f& variance_px2) {
  MeasurementTerms terms;
  for (int i = 0; i < 256; ++i) {
    const double t =
        std::max(0.0, (i / 255.0 - params.ambiguity_onset) / (1.0 - params.ambiguity_onset));
    const double sigma_px = params.sigma_floor_px + params.sigma_ambiguous_px * t * t;
    terms.variance_by_ambiguity_px2[i] = static_cast<float>(sigma_px * sigma_px);
  }
  terms.smallest_valid = static_cast<float>(range.min_disparity);
  variance_px2.create(measured_disparity_px.size());
  parallelForEach(variance_px2.rows, [&](int y) {
    HWY_DYNAMIC_DISPATCH(measurementVarianceRow)
    (measured_disparity_px[y], ambiguity[y], variance_px2.cols, terms, variance_px2[y]);
  });
}

double rectificationShare(double row_offset_px) {
  if (row_offset_px == 0) return 1;
  const double squared = row_offset_px * row_offset_px;
  return squared / (squared + kHalfShareRowOffsetPx * kHalfShareRowOffsetPx);
}

void publish(const cv::Mat1f& disparity_px, const DisparityEvidence& evidence,
             const DisparityRange& range, const VarianceParams& params, cv::Mat1f& published_px,
             cv::Mat1f& variance_px2) {
  createApart("publish", disparity_px, published_px);
  variance_px2.create(disparity_px.size());
  const auto squared = [](double value) { return static_cast<float>(value * value); };
  PublishedTerms terms;
  terms.smallest_valid = static_cast<float>(range.min_disparity);
  terms.invalid = range.invalid();
  terms.unpredicted_px2 =
      squared(params.sigma_unpredicted_px * rectificationShare(evidence.row_offset_px));
  terms.kept_px2 = squared(params.sigma_floor_px);
  terms.filled_px2 = squared(params.sigma_filled_px);
  terms.disagreement_px = static_cast<float>(params.sigma_disagreement_px);
  terms.ambiguity_weight = static_cast<float>(params.ambiguity_weight);
  terms.unpredicted_weight = static_cast<float>(params.unpredicted_weight);
  terms.residual_weight = static_cast<float>(params.residual_weight);
  terms.per_squared_disparity = squared(params.sigma_per_row_offset * evidence.row_offset_px);
  terms.slope_weight = static_cast<float>(params.slope_weight);
  terms.largest_variance_px2 = params.max_sigma_px > 0 ? squared(params.max_sigma_px)
                                                       : std::numeric_limits<float>::infinity();
  parallelForEach(variance_px2.rows, [&](int y) {
    HWY_DYNAMIC_DISPATCH(publishRow)
    ({rowsAround(disparity_px, y), evidence.unfilled_px[y], evidence.predicted_px[y],
      evidence.measured_px[y], evidence.measured_variance_px2[y], evidence.ambiguity[y],
      evidence.residual_share[y / kResidualStep], published_px[y], variance_px2[y]},
     variance_px2.cols, terms);
  });
}

}  // namespace predictive_stereo
#endif
