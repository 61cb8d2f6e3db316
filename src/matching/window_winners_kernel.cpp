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

/// 255 at three neighbouring places, 0 elsewhere.
constexpr int kBeside = 255 + kLanes;
struct BesideTable {
  constexpr BesideTable() {
    for (int i = 0; i < 3; ++i) values[kBeside - 1 + i] = 255;
  }
  uint8_t values[2 * kBeside + kLanes] = {};
};
constexpr BesideTable kBesideTable;

HWY_INLINE void findLeft(const WindowSums& row, int x, int width, RowWinners& winners) {
  const Bytes16 d;
  const uint8_t* sums = row.sums + row.windows.position[x];
  V lowest = hn::LoadU(d, sums);
  for (int k = kLanes; k < width; k += kLanes) lowest = hn::Min(lowest, hn::LoadU(d, sums + k));
  lowest = lowestLane(d, lowest);
  int best = 0;
  for (;; best += kLanes) {
    const intptr_t lane = hn::FindFirstTrue(d, hn::Eq(hn::LoadU(d, sums + best), lowest));
    if (lane < 0) continue;
    best += static_cast<int>(lane);
    break;
  }
  const uint8_t* beside = kBesideTable.values + kBeside - best;
  V runner_up = hn::Set(d, 255);
  for (int k = 0; k < width; k += kLanes)
    runner_up = hn::Min(runner_up, hn::Or(hn::LoadU(d, sums + k), hn::LoadU(d, beside + k)));

  winners.index[x] = static_cast<uint8_t>(row.windows.first[x] + best);
  winners.cost[x] = hn::GetLane(lowest);
  winners.runner_up[x] = hn::GetLane(lowestLane(d, runner_up));
  winners.below[x] = sums[std::max(best - 1, 0)];
  winners.above[x] = sums[std::min(best + 1, width - 1)];
}

/// Entry e stands for right pixel columns - 1 - min_disparity - e and holds 256 * (255 - lowest
/// sum) + (255 - index), so that the largest wins, in whatever order candidates come.
HWY_INLINE void updateRight(const WindowSums& row, int x, int width) {
  const Bytes16 d;
  const Words8 d16;
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

void WindowRowWinners(const WindowSums& row, RowWinners& winners) {
  const int entries = row.columns - 1 + row.range.count;
  std::fill_n(row.right_scratch, entries, uint16_t{0});
  for (int x = 0; x < row.columns; ++x)
    if (row.windows.width[x] > 0) findLeft(row, x, row.windows.width[x], winners);
  // Neighbours write to overlapping entries, and loads that overlap a recent store are slow: so
  // come to them much later.
  constexpr int kDistance = 16;
  for (int start = 0; start < kDistance; ++start)
    for (int x = start; x < row.columns; x += kDistance)
      if (row.windows.width[x] > 0) updateRight(row, x, row.windows.width[x]);
  for (int right_x = 0; right_x < row.columns; ++right_x) {
    const int entry = row.columns - 1 - row.range.min_disparity - right_x;
    const int best = entry >= 0 && entry < entries ? row.right_scratch[entry] : 0;
    winners.rightIndices()[right_x] = best >= 256 ? 255 - best % 256 : RowWinners::kNoIndex;
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
