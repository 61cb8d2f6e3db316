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
    const bool agree = (predicted[x] >= smallest) & (predicted_missed[x] != limits.moving) &
                       (innovation * innovation <= limits.gate * (p + r));
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

// Columns of the right image that see the pixels from x on, if there were such disparities.
template <class D>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> rightColumns(D d, int x, hn::Vec<D> disparity) {
  const auto position = hn::Sub(hn::Iota(d, static_cast<float>(x)), disparity);
  return hn::ConvertTo(hn::RebindToSigned<D>(), hn::Add(position, hn::Set(d, 0.5f)));
}

// Pixels from x on, as long as vectors fit; returns the first that did not. Of two pixels that are
// seen in one column, the one to the right is the nearer.
template <class D>
HWY_INLINE int rightView(D d, const float* measured, int width, float smallest_valid, int x,
                         float* nearest) {
  const hn::RebindToSigned<D> di;
  const auto smallest = hn::Set(d, smallest_valid);
  const auto outside = hn::Set(di, width);
  const int lanes = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN int32_t columns[hn::MaxLanes(D())];
  for (; x + lanes <= width; x += lanes) {
    const auto disparity = hn::LoadU(d, measured + x);
    const auto column = rightColumns(d, x, disparity);
    const auto in_row = hn::And(hn::Gt(column, hn::Set(di, -1)), hn::Lt(column, outside));
    const auto valid = hn::RebindMask(di, hn::Ge(disparity, smallest));
    hn::Store(hn::IfThenElse(hn::And(valid, in_row), column, outside), di, columns);
    for (int i = 0; i < lanes; ++i) nearest[columns[i]] = measured[x + i];
  }
  return x;
}

template <class D>
HWY_INLINE int dropRefutedPixels(D d, const CorrectionRow& row, int width, float smallest_valid,
                                 float invalid, int x, const float* nearest) {
  const hn::RebindToSigned<D> di;
  const auto smallest = hn::Set(d, smallest_valid), step = hn::Set(d, kRefutingStep_px);
  const auto one = hn::Set(di, 1), last = hn::Set(di, width - 1);
  const int lanes = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN int32_t is_refuted[hn::MaxLanes(D())];
  for (; x + lanes <= width; x += lanes) {
    const auto kept = hn::LoadU(d, row.disparity_px + x);
    const auto unmeasured = hn::Lt(hn::LoadU(d, row.measured_px + x), smallest);
    const auto column = rightColumns(d, x, kept);
    const auto in_row = hn::And(hn::Gt(column, hn::Zero(di)), hn::Lt(column, last));
    const auto doubted =
        hn::And(hn::And(unmeasured, hn::Ge(kept, smallest)), hn::RebindMask(d, in_row));
    if (hn::AllFalse(d, doubted)) continue;
    const auto at = hn::IfThenElseZero(hn::RebindMask(di, doubted), hn::Sub(column, one));
    const auto seen =
        hn::Max(hn::Max(hn::GatherIndex(d, nearest, at), hn::GatherIndex(d, nearest + 1, at)),
                hn::GatherIndex(d, nearest + 2, at));
    const auto farther = hn::And(hn::Ge(seen, smallest), hn::Lt(seen, hn::Sub(kept, step)));
    const auto refuted = hn::And(doubted, farther);
    if (hn::AllFalse(d, refuted)) continue;
    const auto variance = hn::LoadU(d, row.variance_px2 + x);
    hn::StoreU(hn::IfThenElse(refuted, hn::Set(d, invalid), kept), d, row.disparity_px + x);
    hn::StoreU(hn::IfThenZeroElse(refuted, variance), d, row.variance_px2 + x);
    hn::Store(hn::VecFromMask(di, hn::RebindMask(di, refuted)), di, is_refuted);
    for (int i = 0; i < lanes; ++i)
      if (is_refuted[i] != 0) row.missed_frames[x + i] = 0;
  }
  return x;
}

void dropRefuted(const CorrectionRow& row, int width, const CorrectionLimits& limits,
                 float* nearest) {
  const hn::ScalableTag<float> vectors;
  const hn::FixedTag<float, 1> pixels;
  const float smallest = limits.smallest_valid, invalid = limits.invalid;
  std::fill_n(nearest, width + kBesideNearest, invalid);
  int x = rightView(vectors, row.measured_px, width, smallest, 0, nearest);
  rightView(pixels, row.measured_px, width, smallest, x, nearest);
  x = dropRefutedPixels(vectors, row, width, smallest, invalid, 0, nearest);
  dropRefutedPixels(pixels, row, width, smallest, invalid, x, nearest);
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(correctRow);
HWY_EXPORT(dropRefuted);

void correctRow(const CorrectionRow& row, int width, const CorrectionLimits& limits) {
  HWY_DYNAMIC_DISPATCH(correctRow)(row, width, limits);
}

void dropRefuted(const CorrectionRow& row, int width, const CorrectionLimits& limits,
                 float* nearest) {
  HWY_DYNAMIC_DISPATCH(dropRefuted)(row, width, limits, nearest);
}

}  // namespace predictive_stereo
#endif
