#include <algorithm>
#include <cmath>

#include "filtering/create_apart.h"
#include "parallel/tasks.h"
#include "predictive_stereo/post_filter.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/holes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "simd/pixel_loop-inl.h"

#ifndef PREDICTIVE_STEREO_HOLE_LIMITS
#define PREDICTIVE_STEREO_HOLE_LIMITS
namespace predictive_stereo {

// At an occlusion boundary the census window, of this reach, covers both surfaces.
constexpr float kHiddenSlack_px = 4.0f;

struct HoleLimits {
  int max_length;
  float tolerance_px;
  float hidden_slack_px;  ///< an occlusion may exceed the difference of disparities by this
};

/// Over so many pixels the slope of a surface beside a hole is measured.
constexpr int kSlopeReach = 8;

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

/// A hole in a line of pixels that are `step` apart.
struct Hole {
  const float* end;  ///< the first valid pixel behind it
  ptrdiff_t step;
  int length;
  int pixels_before, pixels_behind;  ///< of the line, before the hole and after `end`
};

struct Bridge {
  bool found = false;
  float rise = 0;  ///< of the disparity, from pixel to pixel
};

/// The surface over a hole, if both sides belong to one: if they agree, or the mean of their slopes
/// leads from one to the other.
HWY_INLINE Bridge bridge(const Hole& hole, float smallest_valid, const HoleLimits& limits) {
  const auto steps = static_cast<float>(hole.length + 1);
  const float* const before = hole.end - (hole.length + 1) * hole.step;
  const float rise = *hole.end - *before;
  float unexplained = std::abs(rise);
  if (hole.pixels_before > kSlopeReach && hole.pixels_behind >= kSlopeReach) {
    const float first = before[-kSlopeReach * hole.step], last = hole.end[kSlopeReach * hole.step];
    if (first >= smallest_valid && last >= smallest_valid) {
      const float slope = ((*before - first) + (last - *hole.end)) / (2 * kSlopeReach);
      unexplained = std::min(unexplained, std::abs(rise - slope * steps));
    }
  }
  if (unexplained > limits.tolerance_px) return {};
  return {true, rise / steps};
}

/// The first pixel from x on that is valid (kValid) or invalid (!kValid); `width` if there is none.
template <bool kValid>
HWY_INLINE int find(const float* row, int x, int width, float smallest_valid) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto smallest = hn::Set(d, smallest_valid);
  for (; x + lanes <= width; x += lanes) {
    const auto valid = hn::Ge(hn::LoadU(d, row + x), smallest);
    const auto place = hn::FindFirstTrue(d, kValid ? valid : hn::Not(valid));
    if (place >= 0) return x + static_cast<int>(place);
  }
  while (x < width && (row[x] >= smallest_valid) != kValid) ++x;
  return x;
}

HWY_INLINE void fillRun(float before, float rise, int first, int end, float* row) {
  forPixels<float>(first, end, [=](auto d, int x) HWY_ATTR {
    const auto steps = hn::Iota(d, static_cast<float>(x - first + 1));
    hn::StoreU(hn::Add(hn::Set(d, before), hn::Mul(hn::Set(d, rise), steps)), d, row + x);
  });
}

/// Whether a surface that begins here is wide enough to hide what is beside it: at least half as
/// wide as the difference of the disparities.
HWY_INLINE bool isWide(const float* surface, int pixels, float difference, float smallest) {
  const int needed = static_cast<int>(0.5f * difference);
  return needed <= pixels && std::all_of(surface, surface + needed,
                                         [smallest](float pixel) { return pixel >= smallest; });
}

// In place.
void fillHolesOfRow(int width, float smallest_valid, const HoleLimits& limits, float* row) {
  for (int end = 0;;) {  // of the last run
    const int first = find<false>(row, end, width, smallest_valid);
    end = find<true>(row, first, width, smallest_valid);
    if (end >= width) break;
    const int length = end - first;
    if (first == 0 || length > limits.max_length) continue;
    const Bridge over =
        bridge({row + end, 1, length, first, width - 1 - end}, smallest_valid, limits);
    const float before = row[first - 1], difference = row[end] - before;
    const bool hidden = difference > limits.tolerance_px &&
                        static_cast<float>(length) <= difference + limits.hidden_slack_px &&
                        isWide(row + end, width - end, difference, before + limits.tolerance_px);
    if (!over.found && !hidden) continue;
    fillRun(before, over.rise, first, end, row);
  }
}

/// @param end  the pixel behind a hole, in row y.
HWY_INLINE void fillHoleAbove(float* end, ptrdiff_t stride, int y, int height, float smallest_valid,
                              const HoleLimits& limits) {
  const int most = std::min(y - 1, limits.max_length);
  int length = 1;
  while (length <= most && !(end[-(length + 1) * stride] >= smallest_valid)) ++length;
  if (length > most) return;
  const Bridge over =
      bridge({end, stride, length, y - length, height - 1 - y}, smallest_valid, limits);
  if (!over.found) return;
  float* const before = end - (length + 1) * stride;
  for (int i = 1; i <= length; ++i)
    before[i * stride] = *before + over.rise * static_cast<float>(i);
}

// In place.
// @param top  first row, of `width` pixels.
// @param stride  from row to row, in pixels.
void fillHolesOfColumns(float* top, ptrdiff_t stride, int width, int height, float smallest_valid,
                        const HoleLimits& limits) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto smallest = hn::Set(d, smallest_valid);
  for (int y = 1; y < height; ++y) {
    float* const row = top + y * stride;
    const float* const above = row - stride;
    const auto fillAt = [&](int x) {
      if (row[x] >= smallest_valid && !(above[x] >= smallest_valid))
        fillHoleAbove(row + x, stride, y, height, smallest_valid, limits);
    };
    int x = 0;
    for (; x + lanes <= width; x += lanes) {
      const auto ends = hn::AndNot(hn::Ge(hn::LoadU(d, above + x), smallest),
                                   hn::Ge(hn::LoadU(d, row + x), smallest));
      if (HWY_LIKELY(hn::AllFalse(d, ends))) continue;
      for (int i = x; i < x + lanes; ++i) fillAt(i);
    }
    for (; x < width; ++x) fillAt(x);
  }
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(fillHolesOfRow);
HWY_EXPORT(fillHolesOfColumns);

void fillHoles(const DisparityRange& range, int max_length, float tolerance_px,
               const cv::Mat1f& disparity_px, cv::Mat1f& filled_px) {
  createApart("fillHoles", disparity_px, filled_px);
  const cv::Size size = disparity_px.size();
  const auto smallest_valid = static_cast<float>(range.min_disparity);
  const HoleLimits limits{max_length, tolerance_px, kHiddenSlack_px};
  parallelForEach(size.height, [&](int y) {
    std::copy_n(disparity_px[y], size.width, filled_px[y]);
    HWY_DYNAMIC_DISPATCH(fillHolesOfRow)(size.width, smallest_valid, limits, filled_px[y]);
  });
  constexpr int kStrip = 64;  // columns
  parallelForEach((size.width + kStrip - 1) / kStrip, [&](int strip) {
    const int x = strip * kStrip;
    HWY_DYNAMIC_DISPATCH(fillHolesOfColumns)
    (filled_px[0] + x, static_cast<ptrdiff_t>(filled_px.step1()), std::min(kStrip, size.width - x),
     size.height, smallest_valid, limits);
  });
}

}  // namespace predictive_stereo
#endif
