#include "matching/striped_winners_kernel.h"

#include <algorithm>

#include "matching/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/striped_winners_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "matching/path_step-inl.h"
#include "matching/striped_layout-inl.h"

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

#if PREDICTIVE_STEREO_HAS_VECTORS

namespace hn = hwy::HWY_NAMESPACE;

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
      indices_[k] = hn::Load(d_, indices);
      right_goodness_[k] = right_indices_[k] = hn::Zero(d_);
    }
  }

  HWY_INLINE void run() {
    V sums[kK];
    for (int x = 0; x < row_.width; ++x) {
      for (int k = 0; k < kK; ++k) sums[k] = hn::Load(d_, pixel(x) + k * kLanes);
      findLeft(x, sums);
      updateRight(sums);
      leaveRight(x);
    }
    for (int x = 1; x < kSize; ++x) leaveRight(row_.width - 1 + x);
  }

 private:
  const uint8_t* pixel(int x) const { return row_.sums + static_cast<size_t>(x) * kSize; }
  uint8_t sumAt(int x, int index) const { return pixel(x)[index % kK * kLanes + index / kK]; }

  HWY_INLINE void findLeft(int x, const V* sums) const {
    V lowest = sums[0];
    for (int k = 1; k < kK; ++k) lowest = hn::Min(lowest, sums[k]);
    lowest = lowestLane(d_, lowest);
    const V none = hn::Set(d_, 255);
    V best = none;
    for (int k = 0; k < kK; ++k)
      best = hn::Min(best, hn::IfThenElse(hn::Eq(sums[k], lowest), indices_[k], none));
    best = lowestLane(d_, best);

    const V one = hn::Set(d_, 1);
    const V from = hn::SaturatedSub(best, one), to = hn::SaturatedAdd(best, one);
    V runner_up = none;
    for (int k = 0; k < kK; ++k) {
      const auto beside = hn::Eq(indices_[k], hn::Min(hn::Max(indices_[k], from), to));
      runner_up = hn::Min(runner_up, hn::Or(sums[k], hn::VecFromMask(d_, beside)));
    }
    const int index = hn::GetLane(best);
    index_[x] = static_cast<uint8_t>(index);
    cost_[x] = hn::GetLane(lowest);
    runner_up_[x] = hn::GetLane(lowestLane(d_, runner_up));
    below_[x] = sumAt(x, index > 0 ? index - 1 : index);
    above_[x] = sumAt(x, index < row_.range.count - 1 ? index + 1 : index);
  }

  /// Lane i of vector k holds the best so far (255 - sum, and its index) of the right pixel that is
  /// the partner of x at disparity index i * K + k. Larger indices come later and win only if
  /// better.
  HWY_INLINE void updateRight(const V* sums) {
    for (int k = 0; k < kK; ++k) {
      const V goodness = hn::Max(right_goodness_[k], hn::Not(sums[k]));
      const auto stays = hn::Eq(goodness, right_goodness_[k]);
      right_indices_[k] = hn::IfThenElse(stays, right_indices_[k], indices_[k]);
      right_goodness_[k] = goodness;
    }
  }

  /// Goes from left pixel x to the next: one right pixel is complete, all others move on by one
  /// disparity, a new one comes in.
  HWY_INLINE void leaveRight(int x) {
    const int right_x = x - row_.range.min_disparity - (kSize - 1);
    if (right_x >= 0 && right_x < row_.width) {
      const bool found = hn::ExtractLane(right_goodness_[kLast], kLanes - 1) > 0;
      right_index_[right_x] =
          found ? hn::ExtractLane(right_indices_[kLast], kLanes - 1) : RowWinners::kNoIndex;
    }
    const V goodness = lanesUp(d_, right_goodness_[kLast], hn::Zero(d_));
    const V indices = lanesUp(d_, right_indices_[kLast], hn::Zero(d_));
    for (int k = kLast; k > 0; --k) {
      right_goodness_[k] = right_goodness_[k - 1];
      right_indices_[k] = right_indices_[k - 1];
    }
    right_goodness_[0] = goodness;
    right_indices_[0] = indices;
  }

  const D d_{};
  const StripedSums row_;
  uint8_t* const index_;
  uint8_t* const cost_;
  uint8_t* const below_;
  uint8_t* const above_;
  uint8_t* const runner_up_;
  int16_t* const right_index_;
  V indices_[kK], right_goodness_[kK], right_indices_[kK];
};

void StripedRowWinners(const StripedSums& row, RowWinners& winners) {
  std::fill_n(winners.rightIndices(), row.width, RowWinners::kNoIndex);
  callWithVectors(row.layout.vectors,
                  [&](auto vectors) { RowSearch<decltype(vectors)::value>(row, winners).run(); });
}

#else
void StripedRowWinners(const StripedSums&, RowWinners&) {}
#endif

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(StripedRowWinners);

StripedWinnersFunction stripedWinners(int64_t simd_target) {
  return PREDICTIVE_STEREO_DISPATCH(StripedRowWinners, simd_target);
}

}  // namespace predictive_stereo
#endif
