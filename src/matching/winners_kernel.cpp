#include <algorithm>
#include <cstring>

#include "matching/row_winners.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/winners_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "matching/path_step-inl.h"
#include "simd/pixel_loop-inl.h"

#ifndef PREDICTIVE_STEREO_BESIDE_TABLE
#define PREDICTIVE_STEREO_BESIDE_TABLE
namespace predictive_stereo {

/// 255 at three neighbouring positions, 0 elsewhere.
constexpr int kBeside = 255 + 16;
struct BesideTable {
  constexpr BesideTable() {
    for (int i = 0; i < 3; ++i) values[kBeside - 1 + i] = 255;
  }
  uint8_t values[2 * kBeside + 16] = {};
};
constexpr BesideTable kBesideTable;

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

#if PREDICTIVE_STEREO_HAS_VECTORS

// --- Sums of a full search --------------------------------------------------------------------

/// kK: vectors per pixel.
template <int kK>
class RowSearch {
  using D = StripedBytes;
  using V = hn::Vec<D>;
  static constexpr int kLanes = hn::MaxLanes(D());
  static constexpr int kSize = kK * kLanes;
  static constexpr int kLast = kK - 1;

 public:
  RowSearch(const StripedSums& row, RowWinners& winners)
      : row_(row),
        index_(winners.index.data()),
        cost_(winners.cost.data()),
        below_(winners.below.data()),
        above_(winners.above.data()),
        runner_up_(winners.runner_up.data()),
        right_index_(winners.rightIndices()) {
    HWY_ALIGN uint8_t indices[kLanes];
    for (int k = 0; k < kK; ++k) {
      for (int i = 0; i < kLanes; ++i) indices[i] = static_cast<uint8_t>(i * kK + k);
      indices_[k] = right_indices_[k] = hn::Load(d_, indices);
      right_lowest_[k] = none_;
    }
  }

  HWY_INLINE void run() {
    for (int x = 0; x < row_.width; ++x) {
      V sums[kK];
      for (int k = 0; k < kK; ++k) sums[k] = hn::Load(d_, pixel(x) + k * kLanes);
      findLeft(x, sums);
      updateRight(sums);
      finishRightPixel(x);
    }
    V nothing[kK];
    for (V& sums : nothing) sums = none_;
    for (int x = row_.width; x < row_.width + kSize - 1; ++x) {
      updateRight(nothing);
      finishRightPixel(x);
    }
  }

 private:
  const uint8_t* pixel(int x) const { return row_.sums + static_cast<size_t>(x) * kSize; }
  uint8_t sumAt(int x, int index) const { return pixel(x)[index % kK * kLanes + index / kK]; }

  HWY_INLINE void findLeft(int x, const V* sums) const {
    V lowest = sums[0];  // of each lane, with its first index
    V first = indices_[0];
    for (int k = 1; k < kK; ++k) {
      const V lower = hn::Min(lowest, sums[k]);
      first = hn::IfThenElse(hn::Eq(lower, lowest), first, indices_[k]);
      lowest = lower;
    }
    const V cost = lowestLane(d_, lowest);
    const V best = lowestLane(d_, hn::IfThenElse(hn::Eq(lowest, cost), first, none_));

    const V one = hn::Set(d_, 1);
    const V from = hn::SaturatedSub(best, one), to = hn::SaturatedAdd(best, one);
    V runner_up = none_;
    for (int k = 0; k < kK; ++k) {
      const auto beside = hn::Eq(indices_[k], hn::Min(hn::Max(indices_[k], from), to));
      runner_up = hn::Min(runner_up, hn::Or(sums[k], hn::VecFromMask(d_, beside)));
    }
    const int index = hn::GetLane(best);
    index_[x] = static_cast<uint8_t>(index);
    cost_[x] = hn::GetLane(cost);
    runner_up_[x] = hn::GetLane(lowestLane(d_, runner_up));
    below_[x] = sumAt(x, index > 0 ? index - 1 : index);
    above_[x] = sumAt(x, index < row_.shifts.count - 1 ? index + 1 : index);
  }
  /// Lane i of vector k holds the lowest sum so far, and its index, of the right pixel that is the
  /// partner of x at disparity index i * K + k. From one x to the next, every right pixel moves to
  /// the next disparity, and a new right pixel enters. Larger indices come later and win only if
  /// their sum is lower.
  HWY_INLINE void updateRight(const V* sums) {
    const V lowest_of_first = lanesUp(d_, right_lowest_[kLast], none_);
    const V index_of_first = lanesUp(d_, right_indices_[kLast], none_);
    for (int k = kLast; k >= 0; --k) {
      const V lowest = k > 0 ? right_lowest_[k - 1] : lowest_of_first;
      const V index = k > 0 ? right_indices_[k - 1] : index_of_first;
      right_lowest_[k] = hn::Min(lowest, sums[k]);
      right_indices_[k] = hn::IfThenElse(hn::Eq(right_lowest_[k], lowest), index, indices_[k]);
    }
  }

  /// The right pixel at the largest disparity of left pixel x has no further candidates.
  HWY_INLINE void finishRightPixel(int x) const {
    const int right_x = x - row_.shifts.min_disparity - (kSize - 1);
    if (right_x < 0 || right_x >= row_.width) return;
    const hn::Repartition<uint16_t, D> d16;
    const auto pairs =
        hn::BitCast(d16, hn::InterleaveUpper(d_, right_lowest_[kLast], right_indices_[kLast]));
    const int pair = hn::ExtractLane(pairs, kLanes / 2 - 1);
    right_index_[right_x] =
        static_cast<int16_t>((pair & 255) < 255 ? pair >> 8 : RowWinners::kNoIndex);
  }

  const D d_{};
  const StripedSums row_;
  uint8_t* const index_;
  uint8_t* const cost_;
  uint8_t* const below_;
  uint8_t* const above_;
  uint8_t* const runner_up_;
  int16_t* const right_index_;
  const V none_ = hn::Set(d_, 255);
  V indices_[kK], right_lowest_[kK], right_indices_[kK];
};

void StripedRowWinners(const StripedSums& row, RowWinners& winners) {
  std::fill_n(winners.rightIndices(), row.width, RowWinners::kNoIndex);
  callWithVectors(row.layout.vectors,
                  [&](auto vectors) { RowSearch<decltype(vectors)::value>(row, winners).run(); });
}

// --- Sums of a reduced search -----------------------------------------------------------------

/// Windows are processed in groups of 16 disparities.
constexpr int kLanes = 16;
using Bytes16 = hn::FixedTag<uint8_t, kLanes>;
using Words = hn::CappedTag<uint16_t, kLanes>;
constexpr int kWords = hn::MaxLanes(Words());

/// Results of each pixel, as pointers to types that byte writes cannot alias.
struct PixelArrays {
  uint16_t* lowest;
  uint32_t* beside;
  uint8_t* runner_up;
};

/// A pixel's winner, and its candidates for the right image. kWidth: width of its window, or 0 if
/// it is not known at compile time.
/// @param entries  of the right image, for the window's disparities.
template <int kWidth>
HWY_INLINE void describePixel(int x, const uint8_t* sums, int first, int window_width,
                              uint16_t* entries, const PixelArrays& arrays) {
  const Bytes16 d;
  const Words words;
  const hn::Rebind<uint8_t, Words> bytes;
  const int width = kWidth > 0 ? kWidth : window_width;
  // 256 * sum + index: the smallest of these numbers has the lowest sum, and of equal sums the
  // smallest index.
  auto index = hn::Iota(words, static_cast<uint16_t>(first));
  auto lowest = hn::Set(words, 0xFFFF);
  for (int k = 0; k < width; k += kWords) {
    const auto sum = hn::PromoteTo(words, hn::LoadU(bytes, sums + k));
    const auto candidate = hn::Or(hn::ShiftLeft<8>(sum), index);
    lowest = hn::Min(lowest, candidate);
    hn::StoreU(hn::Min(hn::LoadU(words, entries + k), candidate), words, entries + k);
    index = hn::Add(index, hn::Set(words, kWords));
  }
  const uint16_t winner = hn::GetLane(lowestWordToFront(words, lowest));
  const intptr_t best = winner & 255;
  arrays.lowest[x] = winner;
  std::memcpy(arrays.beside + x, (sums - first - 1) + best, sizeof arrays.beside[x]);

  const uint8_t* const beside = (kBesideTable.values + kBeside + first) - best;
  auto runner_up = hn::Or(hn::LoadU(d, sums), hn::LoadU(d, beside));
  for (int k = kLanes; k < width; k += kLanes)
    runner_up = hn::Min(runner_up, hn::Or(hn::LoadU(d, sums + k), hn::LoadU(d, beside + k)));
  arrays.runner_up[x] = lowestOfLanes(d, runner_up);
}

HWY_INLINE void describeRun(const WindowSums& row, const WindowRun& window, int begin,
                            uint16_t* const* right, const PixelArrays& arrays) {
  const uint8_t* const sums = row.sums + window.position;
  const int first = window.first, entry = row.columns - 1 - begin + first;
  uint64_t widths = 0;
  static_assert(sizeof widths == kWindowRun * sizeof *row.width);
  if (begin + kWindowRun <= row.columns) std::memcpy(&widths, row.width + begin, sizeof widths);
  if (widths == kLanes * uint64_t{0x0001000100010001}) {
    for (int k = 0; k < kWindowRun; ++k)
      describePixel<kLanes>(begin + k, sums + k * kLanes, first, kLanes, right[k] + entry - k,
                            arrays);
    return;
  }
  const int pixels = std::min(kWindowRun, row.columns - begin);
  for (int k = 0; k < pixels; ++k) {
    const int x = begin + k;
    if (row.width[x] > 0)
      describePixel<0>(x, sums + k * window.width, first, window.width, right[k] + entry - k,
                       arrays);
    else
      arrays.lowest[x] = 0;
  }
}

/// Splits the combined entries into separate arrays.
void splitWinners(const WindowWinnersScratch& scratch, int columns, RowWinners& winners) {
  const hn::ScalableTag<uint8_t> d;
  hn::Vec<decltype(d)> index, cost, below, same, above, next;
  for (int x = 0; x < columns; x += static_cast<int>(hn::Lanes(d))) {
    hn::LoadInterleaved2(d, reinterpret_cast<const uint8_t*>(&scratch.lowest[x]), index, cost);
    hn::LoadInterleaved4(d, reinterpret_cast<const uint8_t*>(&scratch.beside[x]), below, same,
                         above, next);
    hn::StoreU(index, d, &winners.index[x]);
    hn::StoreU(cost, d, &winners.cost[x]);
    hn::StoreU(below, d, &winners.below[x]);
    hn::StoreU(above, d, &winners.above[x]);
  }
}

/// Entry e stands for right pixel last_entry - e: entries begin ... end - 1 become indices.
void chooseRightWinners(const WindowWinnersScratch& scratch, int begin, int end, int last_entry,
                        int16_t* right_indices) {
  forPixels<uint16_t>(begin, end, [&](auto d, int e) HWY_ATTR {
    const hn::RebindToSigned<decltype(d)> d_index;
    auto winner = hn::LoadU(d, &scratch.right[0][e]);
    for (int k = 1; k < kWindowRun; ++k)
      winner = hn::Min(winner, hn::LoadU(d, &scratch.right[k][e]));
    const auto exists = hn::RebindMask(d_index, hn::Lt(winner, hn::Set(d, 255 << 8)));
    const auto index = hn::BitCast(d_index, hn::And(winner, hn::Set(d, 255)));
    const auto known = hn::IfThenElse(exists, index, hn::Set(d_index, RowWinners::kNoIndex));
    const int last = e + static_cast<int>(hn::Lanes(d)) - 1;
    hn::StoreU(hn::Reverse(d_index, known), d_index, right_indices + last_entry - last);
  });
}

void WindowRowWinners(const WindowSums& window_sums, WindowWinnersScratch& scratch,
                      RowWinners& winners) {
  const WindowSums row = window_sums;  // a copy: writes to bytes cannot alias it
  for (auto& candidates : scratch.right) std::fill(candidates.begin(), candidates.end(), 0xFFFF);
  uint16_t* right[kWindowRun];
  for (int k = 0; k < kWindowRun; ++k) right[k] = scratch.right[k].data();
  const PixelArrays arrays{scratch.lowest.data(), scratch.beside.data(), winners.runner_up.data()};
  // Neighbouring runs write to overlapping entries, and loads that overlap a recent store are slow.
  // Therefore neighbours are processed later.
  constexpr int kDistance = 4;
  const int runs = (row.columns + kWindowRun - 1) / kWindowRun;
  for (int start = 0; start < kDistance; ++start)
    for (int run = start; run < runs; run += kDistance)
      describeRun(row, row.windows[run], run * kWindowRun, right, arrays);
  uint8_t* const first = winners.first.data();
  for (int run = 0; run < runs; ++run) {
    const uint32_t four_times = row.windows[run].first * uint32_t{0x01010101};
    static_assert(sizeof four_times == kWindowRun);
    std::memcpy(first + run * kWindowRun, &four_times, sizeof four_times);
  }
  splitWinners(scratch, row.columns, winners);

  int16_t* const right_indices = winners.rightIndices();
  // Right columns outside the reach of all disparities have no entry.
  const int entries = row.columns - 1 + row.shifts.count;
  const int last_entry = row.columns - 1 - row.shifts.min_disparity;
  const int begin = std::clamp(last_entry - (entries - 1), 0, row.columns);
  const int end = std::clamp(last_entry + 1, begin, row.columns);
  std::fill_n(right_indices, begin, RowWinners::kNoIndex);
  std::fill(right_indices + end, right_indices + row.columns, RowWinners::kNoIndex);
  chooseRightWinners(scratch, last_entry - end + 1, last_entry - begin + 1, last_entry,
                     right_indices);
}

#else
void StripedRowWinners(const StripedSums&, RowWinners&) {}
void WindowRowWinners(const WindowSums&, WindowWinnersScratch&, RowWinners&) {}
#endif

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(StripedRowWinners);
HWY_EXPORT(WindowRowWinners);

StripedWinnersFunction stripedWinners(int64_t simd_target) {
  return PREDICTIVE_STEREO_DISPATCH(StripedRowWinners, simd_target);
}
WindowWinnersFunction windowWinners(int64_t simd_target) {
  return PREDICTIVE_STEREO_DISPATCH(WindowRowWinners, simd_target);
}

void WindowWinnersScratch::resize(int columns, const DisparityRange& range) {
  for (auto& candidates : right)
    candidates.resize(columns - 1 + range.count + RowWinners::kPadding);
  lowest.resize(columns + RowWinners::kPadding);
  beside.resize(columns + RowWinners::kPadding);
}

}  // namespace predictive_stereo
#endif
