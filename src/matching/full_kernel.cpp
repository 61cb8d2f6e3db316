#include "matching/full_kernel.h"

#include <algorithm>

#include "matching/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/full_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "matching/path_step-inl.h"

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

#if PREDICTIVE_STEREO_HAS_VECTORS

namespace hn = hwy::HWY_NAMESPACE;

/// The vectors of one pixel. kK: their number, where it is known at compile time, or 0.
template <class D, int kK>
struct Pixel {
  static constexpr int kMost = kK > 0 ? kK : 16;
  hn::Vec<D> v[kMost];
};

/// Aggregates a row. kK as in Pixel, kNibbles as in FullSearchRow.
template <class D, int kK, int kNibbles, bool kStraight, bool kDiagonal>
class RowAggregation {
  using V = hn::Vec<D>;
  using Vectors = Pixel<D, kK>;
  static constexpr int kLanes = hn::MaxLanes(D());

 public:
  explicit RowAggregation(const FullSearchRow& row)
      : row_(row),
        run_time_vectors_(row.count / kLanes),
        p1_(hn::Set(d_, static_cast<uint8_t>(row.p1))),
        p2_(hn::Set(d_, static_cast<uint8_t>(row.p2))) {
    for (int n = 0; n < kNibbles; ++n) right_[n] = row.right_planes + n * row.right_stride;
  }

  HWY_INLINE void run() const {
    const int step = row_.upward ? -1 : 1;
    int x = row_.upward ? row_.width - 1 : 0;
    Vectors horizontal, behind, costs, sums;
    fill(p2_, horizontal);
    if constexpr (kDiagonal) fill(p2_, behind);
    for (int i = 0; i < row_.width; ++i, x += step) {
      const size_t at = static_cast<size_t>(x) * row_.count;
      const bool is_last = i == row_.width - 1;
      matchingCosts(x, costs);
      if constexpr (kStraight) {
        firstPath(horizontal, costs, horizontal, sums);
        Vectors vertical;
        load(row_.straight + at, vertical);
        nextPath(vertical, costs, vertical, sums);
        store(vertical, row_.straight + at);
      }
      if constexpr (kDiagonal) {
        // Both diagonals are kept by the column where they are needed next: what this row leaves
        // at x, the next row wants at x + step (from_behind) or x - step (from_ahead).
        Vectors path, previous = behind;
        load(row_.from_behind + at, behind);
        if constexpr (kStraight)
          nextPath(previous, costs, path, sums);
        else
          firstPath(previous, costs, path, sums);
        store(path, row_.from_behind + at);
        if (is_last)
          fill(p2_, path);
        else
          load(row_.from_ahead + at + step * row_.count, path);
        nextPath(path, costs, path, sums);
        store(path, row_.from_ahead + at);
      }
      finish(at, sums);
    }
  }

 private:
  HWY_INLINE int vectors() const {
    if constexpr (kK > 0)
      return kK;
    else
      return run_time_vectors_;
  }
  HWY_INLINE void fill(V value, Vectors& pixel) const {
    for (int k = 0; k < vectors(); ++k) pixel.v[k] = value;
  }
  HWY_INLINE void load(const uint8_t* source, Vectors& pixel) const {
    for (int k = 0; k < vectors(); ++k) pixel.v[k] = hn::Load(d_, source + k * kLanes);
  }
  HWY_INLINE void store(const Vectors& pixel, uint8_t* target) const {
    for (int k = 0; k < vectors(); ++k) hn::Store(pixel.v[k], d_, target + k * kLanes);
  }

  /// Hamming distance + P2 of every disparity.
  HWY_INLINE void matchingCosts(int x, Vectors& costs) const {
    const uint8_t* const left = row_.left_planes + x;
    const uint32_t* const offsets = row_.entry_offsets + (row_.width - 1 - x);
    V tables[kNibbles];
    for (int n = 0; n < kNibbles; ++n) {
      const auto* rows = n == 0 ? row_.tables->distance_and_p2 : row_.tables->distance;
      tables[n] = hn::LoadDup128(d_, rows[0] + left[n * row_.left_stride]);
    }
    for (int k = 0; k < vectors(); ++k) {
      V parts[kNibbles];
      for (int n = 0; n < kNibbles; ++n)
        parts[n] = hn::TableLookupBytes(tables[n], hn::LoadU(d_, right_[n] + offsets[k]));
      for (int n = 2; n < kNibbles; n += 2) {
        parts[0] = hn::Add(parts[0], parts[n]);
        parts[1] = hn::Add(parts[1], parts[n + 1]);
      }
      costs.v[k] = hn::Add(parts[0], parts[1]);
    }
  }

  /// One step of a path; kFirst: its costs begin the sums, else they are added.
  template <bool kFirst>
  HWY_INLINE void path(const Vectors& goodness, const Vectors& costs, Vectors& next,
                       Vectors& sums) const {
    const int last = vectors() - 1;
    const V below_first = lanesUp(d_, goodness.v[last]);
    const V above_last = lanesDown(d_, goodness.v[0]);
    Vectors path_costs;
    V lowest = hn::Set(d_, 255);
    for (int k = 0; k <= last; ++k) {
      const V below = k == 0 ? below_first : goodness.v[k - 1];
      const V above = k == last ? above_last : goodness.v[k + 1];
      path_costs.v[k] = pathCost(costs.v[k], goodness.v[k], below, above, p1_);
      lowest = hn::Min(lowest, path_costs.v[k]);
    }
    // At most cost + P2, as some disparity always has goodness P2.
    const V most = hn::Add(lowestLane(d_, lowest), p2_);
    for (int k = 0; k <= last; ++k) {
      next.v[k] = hn::SaturatedSub(most, path_costs.v[k]);
      sums.v[k] = kFirst ? path_costs.v[k] : hn::SaturatedAdd(sums.v[k], path_costs.v[k]);
    }
  }
  HWY_INLINE void firstPath(const Vectors& goodness, const Vectors& costs, Vectors& next,
                            Vectors& sums) const {
    path<true>(goodness, costs, next, sums);
  }
  HWY_INLINE void nextPath(const Vectors& goodness, const Vectors& costs, Vectors& next,
                           Vectors& sums) const {
    path<false>(goodness, costs, next, sums);
  }

  HWY_INLINE void finish(size_t at, Vectors& sums) const {
    if (row_.sums_before)
      for (int k = 0; k < vectors(); ++k)
        sums.v[k] = joinPasses < kStraight &&
                    kDiagonal > (sums.v[k], hn::Load(d_, row_.sums_before + at + k * kLanes));
    store(sums, row_.sums + at);
  }

  const D d_{};
  const FullSearchRow row_;
  const int run_time_vectors_;
  const V p1_, p2_;
  const uint8_t* right_[kNibbles];
};

template <class D, int kK, int kNibbles>
void aggregate(const FullSearchRow& row) {
  if (row.paths == PathSet::kStraight4) RowAggregation<D, kK, kNibbles, true, false>(row).run();
  if (row.paths == PathSet::kDiagonal4) RowAggregation<D, kK, kNibbles, false, true>(row).run();
  if (row.paths == PathSet::kAll8) RowAggregation<D, kK, kNibbles, true, true>(row).run();
}

template <class D, int kK>
void aggregate(const FullSearchRow& row) {
  row.nibbles == 6 ? aggregate<D, kK, 6>(row) : aggregate<D, kK, 8>(row);
}

template <class D>
void aggregate(const FullSearchRow& row) {
  switch (row.count / static_cast<int>(hn::MaxLanes(D()))) {
    case 2:
      return aggregate<D, 2>(row);
    case 4:
      return aggregate<D, 4>(row);
    case 8:
      return aggregate<D, 8>(row);
    default:
      return aggregate<D, 0>(row);
  }
}

int FullSearchLanes(int count) {
  int lanes = HWY_MAX_BYTES < 64 ? HWY_MAX_BYTES : 64;
  while (count % lanes != 0) lanes /= 2;
  return lanes;
}

void AggregateFullRow(const FullSearchRow& row) {
  const int lanes = FullSearchLanes(row.count);
#if HWY_MAX_BYTES >= 64
  if (lanes == 64) return aggregate<hn::FixedTag<uint8_t, 64>>(row);
#endif
#if HWY_MAX_BYTES >= 32
  if (lanes == 32) return aggregate<hn::FixedTag<uint8_t, 32>>(row);
#endif
  if (lanes == 16) return aggregate<hn::FixedTag<uint8_t, 16>>(row);
}

#else
int FullSearchLanes(int) { return 16; }
void AggregateFullRow(const FullSearchRow&) {}
#endif

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(FullSearchLanes);
HWY_EXPORT(AggregateFullRow);

int fullSearchLanes(int64_t simd_target, int count) {
  return PREDICTIVE_STEREO_DISPATCH(FullSearchLanes, simd_target)(count);
}
FullSearchRowFunction fullSearchRow(int64_t simd_target) {
  return PREDICTIVE_STEREO_DISPATCH(AggregateFullRow, simd_target);
}

}  // namespace predictive_stereo
#endif
