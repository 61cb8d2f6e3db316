#include "filtering/range_rows.h"

#include <algorithm>
#include <cmath>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/range_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

// Floor and ceiling that compilers can vectorise; the offset makes every argument positive.
constexpr float kOffset = 1024.0f;
HWY_INLINE int16_t floorOf(float value) {
  return static_cast<int16_t>(static_cast<int>(value + kOffset) - static_cast<int>(kOffset));
}
HWY_INLINE int16_t ceilingOf(float value) {
  return static_cast<int16_t>(static_cast<int>(kOffset) - static_cast<int>(kOffset - value));
}

// Pointers are separate arguments that do not overlap: compilers vectorise these loops only then.
void widenPredictedPixels(const float* HWY_RESTRICT disparity_px,
                          const float* HWY_RESTRICT variance_px2,
                          const uint8_t* HWY_RESTRICT near_edge, const uint8_t* HWY_RESTRICT missed,
                          int width, Margins margins, float smallest_valid, uint8_t moving,
                          int16_t* HWY_RESTRICT first, int16_t* HWY_RESTRICT last) {
  for (int x = 0; x < width; ++x) {
    // Near discontinuities the hull with the neighbours covers both surfaces: the least margin is
    // enough.
    const float by_sigma = margins.sigmas * std::sqrt(variance_px2[x]);
    const float wanted = near_edge[x] != 0 ? margins.least : by_sigma;
    const float margin = std::min(std::max(wanted, margins.least), margins.most);
    const float d = disparity_px[x];
    const int16_t low = floorOf(d - margin), high = ceilingOf(d + margin);
    const bool known = (d >= smallest_valid) & (missed[x] != moving);
    first[x] = known ? low : kEmptyFirst;
    last[x] = known ? high : kEmptyLast;
  }
}

void widenMeasuredPixels(const float* HWY_RESTRICT disparity_px, int width, float margin_px,
                         float smallest_valid, int16_t* HWY_RESTRICT first,
                         int16_t* HWY_RESTRICT last) {
  for (int x = 0; x < width; ++x) {
    const float d = disparity_px[x];
    const int16_t low = floorOf(d - margin_px), high = ceilingOf(d + margin_px);
    first[x] = d >= smallest_valid ? low : kEmptyFirst;
    last[x] = d >= smallest_valid ? high : kEmptyLast;
  }
}

template <class Extreme>
HWY_INLINE void extremeOf3x3(const int16_t* row0, const int16_t* row1, const int16_t* row2,
                             int width, Extreme extreme, int16_t* HWY_RESTRICT columns,
                             int16_t* HWY_RESTRICT out) {
  const hwy::HWY_NAMESPACE::ScalableTag<int16_t> d;
  namespace hn = hwy::HWY_NAMESPACE;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const hn::CappedTag<int16_t, 1> one;
  const auto down = [&](auto tag, int x) {
    hn::StoreU(extreme(extreme(hn::LoadU(tag, row0 + x), hn::LoadU(tag, row1 + x)),
                       hn::LoadU(tag, row2 + x)),
               tag, columns + x);
  };
  const auto across = [&](auto tag, int x, int before, int after) {
    hn::StoreU(extreme(extreme(hn::LoadU(tag, columns + before), hn::LoadU(tag, columns + x)),
                       hn::LoadU(tag, columns + after)),
               tag, out + x);
  };
  int x = 0;
  for (; x + lanes <= width; x += lanes) down(d, x);
  for (; x < width; ++x) down(one, x);
  across(one, 0, 0, std::min(1, width - 1));
  for (x = 1; x + lanes < width; x += lanes) across(d, x, x - 1, x + 1);
  for (; x < width; ++x) across(one, x, std::max(x - 1, 0), std::min(x + 1, width - 1));
}

void hullOfRows(const ConstRangeRow rows[3], int width, const RangeRow& column_hull,
                const RangeRow& hull) {
  namespace hn = hwy::HWY_NAMESPACE;
  const auto lower = [](auto a, auto b) { return hn::Min(a, b); };
  const auto higher = [](auto a, auto b) { return hn::Max(a, b); };
  extremeOf3x3(rows[0].first, rows[1].first, rows[2].first, width, lower, column_hull.first,
               hull.first);
  extremeOf3x3(rows[0].last, rows[1].last, rows[2].last, width, higher, column_hull.last,
               hull.last);
}

HWY_NOINLINE void uniteWithCoarsePixels(const int16_t* HWY_RESTRICT coarse_first,
                                        const int16_t* HWY_RESTRICT coarse_last, int pairs,
                                        int16_t* HWY_RESTRICT first, int16_t* HWY_RESTRICT last) {
  for (int x = 0; x < pairs; ++x) {
    first[2 * x] = std::min(first[2 * x], coarse_first[x]);
    first[2 * x + 1] = std::min(first[2 * x + 1], coarse_first[x]);
    last[2 * x] = std::max(last[2 * x], coarse_last[x]);
    last[2 * x + 1] = std::max(last[2 * x + 1], coarse_last[x]);
  }
}

void uniteWithCoarse(const ConstRangeRow& coarse, int coarse_width, int width,
                     const RangeRow& ranges) {
  if (coarse_width == 0) return;
  uniteWithCoarsePixels(coarse.first, coarse.last, coarse_width, ranges.first, ranges.last);
  for (int x = 2 * coarse_width; x < width; ++x) {
    ranges.first[x] = std::min(ranges.first[x], coarse.first[coarse_width - 1]);
    ranges.last[x] = std::max(ranges.last[x], coarse.last[coarse_width - 1]);
  }
}

void unitePixels(const int16_t* HWY_RESTRICT first, const int16_t* HWY_RESTRICT last, int width,
                 int16_t* HWY_RESTRICT hull_first, int16_t* HWY_RESTRICT hull_last) {
  for (int x = 0; x < width; ++x) {
    hull_first[x] = std::min(hull_first[x], first[x]);
    hull_last[x] = std::max(hull_last[x], last[x]);
  }
}

void cutRanges(const ConstRangeRow& otherwise, int width, int16_t smallest, int16_t largest,
               const RangeRow& ranges) {
  namespace hn = hwy::HWY_NAMESPACE;
  const auto cut = [&](auto d, int x) {
    const auto first = hn::LoadU(d, ranges.first + x), last = hn::LoadU(d, ranges.last + x);
    const auto unknown = hn::Gt(first, last);
    hn::StoreU(hn::IfThenElse(unknown, hn::LoadU(d, otherwise.first + x),
                              hn::Max(first, hn::Set(d, smallest))),
               d, ranges.first + x);
    hn::StoreU(hn::IfThenElse(unknown, hn::LoadU(d, otherwise.last + x),
                              hn::Min(last, hn::Set(d, largest))),
               d, ranges.last + x);
  };
  const hn::ScalableTag<int16_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  int x = 0;
  for (; x + lanes <= width; x += lanes) cut(d, x);
  for (; x < width; ++x) cut(hn::CappedTag<int16_t, 1>(), x);
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(widenPredictedPixels);
HWY_EXPORT(widenMeasuredPixels);
HWY_EXPORT(hullOfRows);
HWY_EXPORT(uniteWithCoarse);
HWY_EXPORT(unitePixels);
HWY_EXPORT(cutRanges);

void widenPredicted(const PredictedRow& row, int width, const Margins& margins,
                    float smallest_valid, uint8_t moving, const RangeRow& ranges) {
  HWY_DYNAMIC_DISPATCH(widenPredictedPixels)
  (row.disparity_px, row.variance_px2, row.near_edge, row.missed_frames, width, margins,
   smallest_valid, moving, ranges.first, ranges.last);
}

void widenMeasured(const float* disparity_px, int width, float margin_px, float smallest_valid,
                   const RangeRow& ranges) {
  HWY_DYNAMIC_DISPATCH(widenMeasuredPixels)
  (disparity_px, width, margin_px, smallest_valid, ranges.first, ranges.last);
}

void hullOfRows(const ConstRangeRow rows[3], int width, const RangeRow& column_hull,
                const RangeRow& hull) {
  HWY_DYNAMIC_DISPATCH(hullOfRows)(rows, width, column_hull, hull);
}

void uniteWithCoarse(const ConstRangeRow& coarse, int coarse_width, int width,
                     const RangeRow& ranges) {
  HWY_DYNAMIC_DISPATCH(uniteWithCoarse)(coarse, coarse_width, width, ranges);
}

void uniteRows(const ConstRangeRow& ranges, int width, const RangeRow& hull) {
  HWY_DYNAMIC_DISPATCH(unitePixels)(ranges.first, ranges.last, width, hull.first, hull.last);
}

void cutRanges(const ConstRangeRow& otherwise, int width, int16_t smallest, int16_t largest,
               const RangeRow& ranges) {
  HWY_DYNAMIC_DISPATCH(cutRanges)(otherwise, width, smallest, largest, ranges);
}

}  // namespace predictive_stereo
#endif
