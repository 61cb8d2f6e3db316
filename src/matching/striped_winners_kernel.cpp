#include <algorithm>

#include "matching/row_winners.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/striped_winners_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "matching/path_step-inl.h"

PREDICTIVE_STEREO_BEGIN_KERNELS;

#if PREDICTIVE_STEREO_HAS_VECTORS

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

#else
void StripedRowWinners(const StripedSums&, RowWinners&) {}
#endif

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(StripedRowWinners);

StripedWinnersFunction stripedWinners(int64_t simd_target) {
  return PREDICTIVE_STEREO_DISPATCH(StripedRowWinners, simd_target);
}

}  // namespace predictive_stereo
#endif
