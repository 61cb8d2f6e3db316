#include "matching/window_winners_kernel.h"

#include <algorithm>

#include "matching/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/window_winners_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "matching/path_step-inl.h"

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

#if PREDICTIVE_STEREO_HAS_VECTORS

namespace hn = hwy::HWY_NAMESPACE;
using Bytes16 = hn::FixedTag<uint8_t, 16>;
using Words8 = hn::FixedTag<uint16_t, 8>;
using V = hn::Vec<Bytes16>;
constexpr int kLanes = 16;

/// Members of RowWinners.
struct WinnerArrays {
  uint8_t *index, *cost, *below, *above, *runner_up;
};

/// 255 at three neighbouring places, 0 elsewhere.
constexpr int kBeside = 255 + kLanes;
struct BesideTable {
  constexpr BesideTable() {
    for (int i = 0; i < 3; ++i) values[kBeside - 1 + i] = 255;
  }
  uint8_t values[2 * kBeside + kLanes] = {};
};
constexpr BesideTable kBesideTable;

/// kWidth: width of the window, where it is known at compile time, or 0.
template <int kWidth>
HWY_INLINE void findLeft(const WindowSums& row, int x, int window_width,
                         const WinnerArrays& winners) {
  const Bytes16 d;
  const int width = kWidth > 0 ? kWidth : window_width;
  const uint8_t* sums = row.sums + row.windows.position[x];
  V lowest = hn::LoadU(d, sums);
  for (int k = kLanes; k < width; k += kLanes) lowest = hn::Min(lowest, hn::LoadU(d, sums + k));
  lowest = lowestLane(d, lowest);
  intptr_t best = hn::FindFirstTrue(d, hn::Eq(hn::LoadU(d, sums), lowest));
  for (int k = kLanes; kWidth != kLanes && best < 0; k += kLanes) {
    const intptr_t lane = hn::FindFirstTrue(d, hn::Eq(hn::LoadU(d, sums + k), lowest));
    if (lane >= 0) best = k + lane;
  }
  const uint8_t* beside = kBesideTable.values + kBeside - best;
  V runner_up = hn::Or(hn::LoadU(d, sums), hn::LoadU(d, beside));
  for (int k = kLanes; k < width; k += kLanes)
    runner_up = hn::Min(runner_up, hn::Or(hn::LoadU(d, sums + k), hn::LoadU(d, beside + k)));

  winners.index[x] = static_cast<uint8_t>(row.windows.first[x] + best);
  winners.cost[x] = hn::GetLane(lowest);
  winners.runner_up[x] = hn::GetLane(lowestLane(d, runner_up));
  winners.below[x] = sums[best > 0 ? best - 1 : 0];
  winners.above[x] = sums[best < width - 1 ? best + 1 : width - 1];
}

/// Entry e stands for right pixel columns - 1 - min_disparity - e and holds 256 * (255 - lowest
/// sum) + (255 - index), so that the largest wins, in whatever order candidates come.
template <int kWidth>
HWY_INLINE void updateRight(const WindowSums& row, int x, int window_width) {
  const Bytes16 d;
  const Words8 d16;
  const int width = kWidth > 0 ? kWidth : window_width;
  const uint8_t* sums = row.sums + row.windows.position[x];
  const int first = row.windows.first[x];
  uint16_t* entries = row.right_scratch + (row.columns - 1 - x) + first;
  V index = hn::Sub(hn::Set(d, static_cast<uint8_t>(255 - first)), hn::Iota(d, 0));
  for (int k = 0; k < width; k += kLanes) {
    const V goodness = hn::Not(hn::LoadU(d, sums + k));
    const auto low = hn::BitCast(d16, hn::InterleaveLower(d, index, goodness));
    const auto high = hn::BitCast(d16, hn::InterleaveUpper(d, index, goodness));
    hn::StoreU(hn::Max(hn::LoadU(d16, entries + k), low), d16, entries + k);
    hn::StoreU(hn::Max(hn::LoadU(d16, entries + k + 8), high), d16, entries + k + 8);
    index = hn::Sub(index, hn::Set(d, kLanes));
  }
}

void WindowRowWinners(const WindowSums& window_sums, RowWinners& winners) {
  const WindowSums row = window_sums;  // a copy, which bytes that are written cannot alias
  const WinnerArrays arrays{winners.index.data(), winners.cost.data(), winners.below.data(),
                            winners.above.data(), winners.runner_up.data()};
  const int entries = row.columns - 1 + row.range.count;
  std::fill_n(row.right_scratch, entries, uint16_t{0});
  for (int x = 0; x < row.columns; ++x) {
    const int width = row.windows.width[x];
    if (width == kLanes)
      findLeft<kLanes>(row, x, width, arrays);
    else if (width > 0)
      findLeft<0>(row, x, width, arrays);
  }
  // Neighbours write to overlapping entries, and loads that overlap a recent store are slow: so
  // come to them much later.
  constexpr int kDistance = 16;
  for (int start = 0; start < kDistance; ++start)
    for (int x = start; x < row.columns; x += kDistance) {
      const int width = row.windows.width[x];
      if (width == kLanes)
        updateRight<kLanes>(row, x, width);
      else if (width > 0)
        updateRight<0>(row, x, width);
    }

  int16_t* const right_indices = winners.rightIndices();
  // Right columns that no disparity reaches have no entry.
  const int last_entry = row.columns - 1 - row.range.min_disparity;
  const int begin = std::clamp(last_entry - (entries - 1), 0, row.columns);
  const int end = std::clamp(last_entry + 1, begin, row.columns);
  std::fill_n(right_indices, begin, RowWinners::kNoIndex);
  std::fill(right_indices + end, right_indices + row.columns, RowWinners::kNoIndex);
  for (int right_x = begin; right_x < end; ++right_x) {
    const int best = row.right_scratch[last_entry - right_x];
    right_indices[right_x] =
        static_cast<int16_t>(best >= 256 ? 255 - (best & 255) : RowWinners::kNoIndex);
  }
}

#else
void WindowRowWinners(const WindowSums&, RowWinners&) {}
#endif

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(WindowRowWinners);

WindowWinnersFunction windowWinners(int64_t simd_target) {
  return PREDICTIVE_STEREO_DISPATCH(WindowRowWinners, simd_target);
}

}  // namespace predictive_stereo
#endif
