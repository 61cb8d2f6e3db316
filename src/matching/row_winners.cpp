#include "matching/row_winners.h"

#include <algorithm>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/row_winners.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "simd/pixel_loop-inl.h"

PREDICTIVE_STEREO_BEGIN_KERNELS;

#if PREDICTIVE_STEREO_HAS_VECTORS

/// The formulas are those of reference_sgm.cpp. See describeRow.
void DescribePixels(const RowWinners& winners, const DisparityRange& range, float fraction_px,
                    const uint8_t* first, const uint16_t* widths, int columns, float* disparity_px,
                    uint8_t* ambiguity) {
  const uint8_t *indices = winners.index.data(), *costs = winners.cost.data(),
                *belows = winners.below.data(), *aboves = winners.above.data(),
                *runners_up = winners.runner_up.data(), *agreement = winners.agreement.data();
  forPixels<float>(0, columns, [=](auto df, int x) HWY_ATTR {
    const hn::RebindToSigned<decltype(df)> di;
    const hn::Rebind<uint8_t, decltype(df)> d8;
    const hn::Rebind<uint16_t, decltype(df)> d16;
    const auto load = [&](const uint8_t* values)
                          HWY_ATTR { return hn::PromoteTo(di, hn::LoadU(d8, values + x)); };
    const auto zero = hn::Zero(di), one = hn::Set(di, 1), white = hn::Set(di, 255);
    const auto fraction = hn::Set(df, fraction_px);
    const auto lowest = hn::Set(df, static_cast<float>(range.min_disparity));
    const auto index = load(indices), cost = load(costs);
    const auto below = load(belows), above = load(aboves), runner_up = load(runners_up);
    const auto begin = first ? load(first) : zero;
    const auto width =
        widths ? hn::PromoteTo(di, hn::LoadU(d16, widths + x)) : hn::Set(di, range.count);
    const auto searched = hn::Gt(width, zero);
    const auto last = hn::Sub(hn::Add(begin, width), one);
    const auto inside = hn::And(hn::Gt(index, begin), hn::Lt(index, last));

    const auto steeper = hn::Sub(hn::Max(below, above), cost);
    const auto offset = hn::Div(hn::ConvertTo(df, hn::Sub(below, above)),
                                hn::ConvertTo(df, hn::Max(hn::Add(steeper, steeper), one)));
    const auto winner = hn::Add(hn::ConvertTo(df, hn::Add(index, hn::Set(di, range.min_disparity))),
                                hn::IfThenElseZero(hn::RebindMask(df, inside), offset));
    const auto disparity = hn::Max(hn::Sub(winner, fraction), lowest);
    const auto valid = hn::And(searched, hn::Gt(load(agreement), zero));
    hn::StoreU(hn::IfThenElse(hn::RebindMask(df, valid), disparity, hn::Set(df, range.invalid())),
               df, disparity_px + x);

    const auto ratio = hn::ConvertTo(di, hn::Div(hn::ConvertTo(df, hn::Mul(cost, white)),
                                                 hn::ConvertTo(df, hn::Max(runner_up, one))));
    const auto agrees_closely = hn::Gt(load(agreement), one);
    const auto has_ratio = hn::And(hn::And(searched, hn::Gt(runner_up, zero)), agrees_closely);
    hn::StoreU(hn::DemoteTo(d8, hn::IfThenElse(has_ratio, ratio, white)), d8, ambiguity + x);
  });
}

#else
void DescribePixels(const RowWinners&, const DisparityRange&, float, const uint8_t*,
                    const uint16_t*, int, float*, uint8_t*) {}
#endif

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(DescribePixels);

void RowWinners::resize(int width, const DisparityRange& shifts) {
  for (auto* values : {&index, &cost, &below, &above, &runner_up, &first, &agreement})
    values->resize(width + kPadding);
  // Left columns 0 ... width - 1 match right columns -largest shift ... width - 1 - smallest shift.
  right_margin_ = std::max(shifts.max_disparity(), 0);
  right_index_.assign(right_margin_ + width + std::max(-shifts.min_disparity, 0), kNoIndex);
}

void describeRow(RowWinners& winners, const MatcherParams& params, const PrincipalOffset& offset,
                 int64_t simd_target, int y, const uint8_t* first, const uint16_t* width,
                 Match& match) {
  const int columns = match.disparity_px.cols;
  // Left-right check: the right pixel's winner must be close to that of the left pixel.
  const int tolerance = params.left_right_tolerance_px;
  const int16_t* const right =
      winners.rightIndices() - offset.columnShifts(params.range).min_disparity;
  const uint8_t* const indices = winners.index.data();
  uint8_t* const agreement = winners.agreement.data();
  for (int x = 0; x < columns; ++x) {
    const int index = indices[x], difference = right[x - index] - index;
    // |difference| <= limit, by one comparison
    const bool agrees = static_cast<unsigned>(difference + tolerance) <= 2U * tolerance;
    const bool closely = static_cast<unsigned>(difference + 1) <= 2U;
    agreement[x] = static_cast<uint8_t>(agrees * (1 + closely));
  }
  if (tolerance < 0) std::fill_n(agreement, columns, uint8_t{2});

  PREDICTIVE_STEREO_DISPATCH(DescribePixels, simd_target)
  (winners, params.range, offset.fraction_px, first, width, columns, match.disparity_px[y],
   match.ambiguity[y]);
}

}  // namespace predictive_stereo
#endif
