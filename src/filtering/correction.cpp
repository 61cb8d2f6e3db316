#include "predictive_stereo/correction.h"

#include <algorithm>
#include <limits>

#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/correction.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "simd/pixel_loop-inl.h"

#ifndef PREDICTIVE_STEREO_CORRECTION_ROW
#define PREDICTIVE_STEREO_CORRECTION_ROW
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
  uint8_t moving, seen_once;  ///< see kMovesByItself, kSeenOnce
  float principal_offset_px;
};

constexpr float kRefutingStep_px = 3.0f;
constexpr int kBesideNearest = 2;

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

void correctRow(const CorrectionRow& row, int width, const CorrectionLimits& limits) {
  forPixels<float>(0, width, [row, limits](auto d, int x) HWY_ATTR {
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<uint8_t, decltype(d)> d8;
    const auto one = hn::Set(d, 1.0f), r = hn::Set(d, limits.r_px2), gate = hn::Set(d, limits.gate);
    const auto smallest = hn::Set(d, limits.smallest_valid), invalid = hn::Set(d, limits.invalid);
    const auto most_missed = hn::Set(di, limits.max_missed_frames);
    const auto moving = hn::Set(di, limits.moving);
    const auto z = hn::LoadU(d, row.measured_px + x);
    const auto predicted = hn::LoadU(d, row.predicted_px + x);
    const auto p = hn::LoadU(d, row.predicted_variance_px2 + x);
    const auto missed = hn::PromoteTo(di, hn::LoadU(d8, row.predicted_missed_frames + x));
    const auto is_measured = hn::Ge(z, smallest), is_predicted = hn::Ge(predicted, smallest);
    const auto alive = hn::And(is_predicted, hn::RebindMask(d, hn::Lt(missed, most_missed)));
    const auto still = hn::RebindMask(d, hn::Ne(missed, moving));

    const auto innovation = hn::Sub(z, predicted), sum = hn::Add(p, r);
    const auto expected = hn::Le(hn::Mul(innovation, innovation), hn::Mul(gate, sum));
    const auto agree = hn::And(hn::And(is_predicted, still), expected);
    // eq. 5 and 6; with gain 1 they give the measurement and r.
    const auto gain = hn::IfThenElse(agree, hn::Div(p, sum), one);
    const auto rest = hn::Sub(one, gain);
    const auto fused = hn::Add(predicted, hn::Mul(gain, innovation));
    const auto corrected = hn::IfThenElse(agree, fused, z);
    const auto corrected_variance =
        hn::Add(hn::Mul(hn::Mul(rest, rest), p), hn::Mul(hn::Mul(gain, gain), r));

    const auto kept = hn::IfThenElse(alive, predicted, invalid);
    const auto kept_variance = hn::IfThenElseZero(alive, p);
    hn::StoreU(hn::IfThenElse(is_measured, corrected, kept), d, row.disparity_px + x);
    hn::StoreU(hn::IfThenElse(is_measured, corrected_variance, kept_variance), d,
               row.variance_px2 + x);
    const auto kept_on = hn::RebindMask(di, hn::AndNot(is_measured, alive));
    // Near discontinuities p covers the whole range, and any measurement passes the gate. That does
    // not confirm the filter: p is limited to r here.
    const auto surely =
        hn::Le(hn::Mul(innovation, innovation), hn::Mul(gate, hn::Add(hn::Min(p, r), r)));
    const auto confirmed = hn::And(agree, surely);
    const auto unconfirmed = hn::RebindMask(di, hn::AndNot(confirmed, is_measured));
    const auto missed_again = hn::IfThenElseZero(kept_on, hn::Add(missed, hn::Set(di, 1)));
    const auto missed_now =
        hn::IfThenElse(unconfirmed, hn::Set(di, limits.seen_once), missed_again);
    hn::StoreU(hn::DemoteTo(d8, missed_now), d8, row.missed_frames + x);
  });
}

// Right image columns of the pixels from x on with these disparities.
template <class D>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> rightColumns(D d, int x, float principal_offset_px,
                                                       hn::Vec<D> disparity) {
  const float at_infinity = static_cast<float>(x) - principal_offset_px;
  const auto position = hn::Sub(hn::Iota(d, at_infinity), disparity);
  // ConvertTo() alone would move what is beside the first column into it.
  return hn::ConvertTo(hn::RebindToSigned<D>(), hn::Floor(hn::Add(position, hn::Set(d, 0.5f))));
}

// The disparities as the right camera sees them. Of two pixels in one right column, the one with
// the larger x is nearer and overwrites the other.
HWY_INLINE void rightView(const float* measured, int width, const CorrectionLimits& limits,
                          float* nearest) {
  forPixels<float>(0, width, [=](auto d, int x) HWY_ATTR {
    const hn::RebindToSigned<decltype(d)> di;
    const auto smallest = hn::Set(d, limits.smallest_valid);
    const auto outside = hn::Set(di, width);
    const auto disparity = hn::LoadU(d, measured + x);
    const auto column = rightColumns(d, x, limits.principal_offset_px, disparity);
    const auto in_row = hn::And(hn::Gt(column, hn::Set(di, -1)), hn::Lt(column, outside));
    const auto valid = hn::RebindMask(di, hn::Ge(disparity, smallest));
    HWY_ALIGN int32_t columns[hn::MaxLanes(di)];
    hn::Store(hn::IfThenElse(hn::And(valid, in_row), column, outside), di, columns);
    for (size_t i = 0; i < hn::Lanes(d); ++i)
      nearest[static_cast<uint32_t>(columns[i])] = measured[x + i];
  });
}

// In place: the maximum of each entry and the two after it.
HWY_INLINE void largestOfThree(int width, float* nearest) {
  forPixels<float>(0, width, [=](auto d, int x) HWY_ATTR {
    const auto two = hn::Max(hn::LoadU(d, nearest + x), hn::LoadU(d, nearest + x + 1));
    hn::StoreU(hn::Max(two, hn::LoadU(d, nearest + x + 2)), d, nearest + x);
  });
}

// @param nearest  largest disparity in each right column and its two neighbours.
HWY_INLINE void dropRefutedPixels(const CorrectionRow& row, int width,
                                  const CorrectionLimits& limits, const float* nearest) {
  forPixels<float>(0, width, [=](auto d, int x) HWY_ATTR {
    const hn::RebindToSigned<decltype(d)> di;
    const auto smallest = hn::Set(d, limits.smallest_valid), step = hn::Set(d, kRefutingStep_px);
    const auto one = hn::Set(di, 1), last = hn::Set(di, width - 1);
    const auto kept = hn::LoadU(d, row.disparity_px + x);
    const auto unmeasured = hn::Lt(hn::LoadU(d, row.measured_px + x), smallest);
    const auto unfounded = hn::And(unmeasured, hn::Ge(kept, smallest));
    if (hn::AllFalse(d, unfounded)) return;
    const auto column = rightColumns(d, x, limits.principal_offset_px, kept);
    const auto in_row = hn::And(hn::Gt(column, hn::Zero(di)), hn::Lt(column, last));
    const auto doubted = hn::And(unfounded, hn::RebindMask(d, in_row));
    const auto at = hn::IfThenElseZero(hn::RebindMask(di, doubted), hn::Sub(column, one));
    const auto seen = hn::GatherIndex(d, nearest, at);
    const auto farther = hn::And(hn::Ge(seen, smallest), hn::Lt(seen, hn::Sub(kept, step)));
    const auto refuted = hn::And(doubted, farther);
    if (hn::AllFalse(d, refuted)) return;
    const auto variance = hn::LoadU(d, row.variance_px2 + x);
    hn::StoreU(hn::IfThenElse(refuted, hn::Set(d, limits.invalid), kept), d, row.disparity_px + x);
    hn::StoreU(hn::IfThenZeroElse(refuted, variance), d, row.variance_px2 + x);
    HWY_ALIGN int32_t is_refuted[hn::MaxLanes(di)];
    hn::Store(hn::VecFromMask(di, hn::RebindMask(di, refuted)), di, is_refuted);
    for (size_t i = 0; i < hn::Lanes(d); ++i)
      if (is_refuted[i] != 0) row.missed_frames[x + i] = 0;
  });
}

// Drops a prediction that correctRow() kept without a measurement, if the right image's row matches
// a disparity more than kRefutingStep_px smaller on the line of sight to it.
// @param nearest  scratch memory of width + kBesideNearest entries.
void dropRefuted(const CorrectionRow& row, int width, const CorrectionLimits& limits,
                 float* nearest) {
  std::fill_n(nearest, width + kBesideNearest, limits.invalid);
  rightView(row.measured_px, width, limits, nearest);
  largestOfThree(width, nearest);
  dropRefutedPixels(row, width, limits, nearest);
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(correctRow);
HWY_EXPORT(dropRefuted);

void correct(const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
             const DisparityRange& range, const CorrectionParams& params, DisparityState& state,
             double principal_offset_px) {
  const cv::Size size = measured_disparity_px.size();
  state.disparity_px.create(size);
  state.variance_px2.create(size);
  state.missed_frames.create(size);
  CorrectionLimits limits;
  limits.smallest_valid = static_cast<float>(range.min_disparity);
  limits.invalid = range.invalid();
  limits.r_px2 = static_cast<float>(params.measurement_noise_px2);
  limits.gate = params.gate_sigma > 0 ? static_cast<float>(params.gate_sigma * params.gate_sigma)
                                      : std::numeric_limits<float>::infinity();
  limits.max_missed_frames = params.max_missed_frames;
  limits.moving = kMovesByItself;
  limits.seen_once = kSeenOnce;
  limits.principal_offset_px = static_cast<float>(principal_offset_px);
  parallelFor(cv::Range(0, size.height), [&](const cv::Range& part) {
    cv::AutoBuffer<float, 4096> nearest(static_cast<size_t>(size.width + kBesideNearest));
    for (int y = part.start; y < part.end; ++y) {
      const CorrectionRow row{measured_disparity_px[y],   prediction.disparity_px[y],
                              prediction.variance_px2[y], prediction.missed_frames[y],
                              state.disparity_px[y],      state.variance_px2[y],
                              state.missed_frames[y]};
      HWY_DYNAMIC_DISPATCH(correctRow)(row, size.width, limits);
      HWY_DYNAMIC_DISPATCH(dropRefuted)(row, size.width, limits, nearest.data());
    }
  });
}

}  // namespace predictive_stereo
#endif
