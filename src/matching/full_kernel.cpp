#include "matching/full_kernel.h"

#include <algorithm>

#include "matching/census.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/full_kernel.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "matching/path_step-inl.h"

PREDICTIVE_STEREO_BEGIN_KERNELS;

#if PREDICTIVE_STEREO_HAS_VECTORS

/// Aggregates a row. kK: vectors per pixel.
template <int kK, bool kStraight, bool kDiagonal>
class RowAggregation {
  using D = StripedBytes;
  using V = hn::Vec<D>;
  static constexpr int kLanes = hn::MaxLanes(D());
  static constexpr int kSize = kK * kLanes;

  struct Pixel {
    HWY_INLINE Pixel() {}  // explicit: on Arm an implicit one is compiled for another target
    V v[kK];
  };
  /// A path at one pixel: its costs, and P2 + the lowest of them.
  struct Path {
    HWY_INLINE Path() {}
    Pixel costs;
    V most;
  };

 public:
  explicit RowAggregation(const FullSearchRow& row)
      : row_(row),
        p1_(hn::Set(d_, static_cast<uint8_t>(row.p1))),
        p2_(hn::Set(d_, static_cast<uint8_t>(row.p2))) {
    for (int n = 0; n < kCensusNibbles; ++n) right_[n] = row.right_planes + n * row.right_stride;
  }

  HWY_INLINE void run() const {
    if constexpr (kStraight && !kDiagonal) {
      if (row_.part == RowPart::kAcross) return walkFromBothEnds();
      if (row_.part == RowPart::kDown) return followVerticals();
    }
    const int step = row_.upward ? -1 : 1;
    int x = row_.upward ? row_.width - 1 : 0;
    Path horizontal, behind;
    start(horizontal);
    if constexpr (kDiagonal) start(behind);
    for (int i = 0; i < row_.width; ++i, x += step) {
      Pixel costs, sums;
      matchingCosts(x, costs);
      const uint8_t down = row_.floors_down[x];
      const uint8_t across = row_.floors_across[row_.upward ? x + 1 : x];
      if constexpr (kStraight) {
        walk(costs, across, horizontal);
        sums = horizontal.costs;

        Path vertical;
        load(row_.straight, x, vertical);
        follow(vertical, costs, down, vertical);
        store(vertical, row_.straight, x);
        add(vertical.costs, sums);
      }
      if constexpr (kDiagonal) {
        // Both diagonals are stored at the column that needs them next: the state at x of this row
        // is used at x + step (from_behind) or x - step (from_ahead) of the next row.
        Path path = behind;
        load(row_.from_behind, x, behind);
        follow(path, costs, std::max(across, down), path);
        store(path, row_.from_behind, x);
        if constexpr (kStraight)
          add(path.costs, sums);
        else
          sums = path.costs;
        if (i == row_.width - 1)
          start(path);
        else
          load(row_.from_ahead, x + step, path);
        const uint8_t across_ahead = row_.floors_across[row_.upward ? x : x + 1];
        follow(path, costs, std::max(across_ahead, down), path);
        store(path, row_.from_ahead, x);
        add(path.costs, sums);
      }
      finish(x, sums);
    }
    hwy::FlushStream();
  }

 private:
  /// Both horizontal paths at the same time, as each one waits for its own lowest cost.
  HWY_INLINE void walkFromBothEnds() const {
    Path forward, backward;
    start(forward);
    start(backward);
    for (int x = 0, mirrored = row_.width - 1; mirrored >= 0; ++x, --mirrored) {
      walkAt(x, row_.floors_across[x], x <= mirrored, forward);
      walkAt(mirrored, row_.floors_across[mirrored + 1], x < mirrored, backward);
    }
  }

  /// The first of both paths at a pixel computes the matching costs, the other one completes the
  /// sum.
  HWY_INLINE void walkAt(int x, uint8_t floor, bool is_first, Path& path) const {
    Pixel costs, sums;
    if (is_first) {
      matchingCosts(x, costs);
      keep(costs, row_.costs, x);
      walk(costs, floor, path);
      keep(path.costs, row_.sums, x);
    } else {
      recall(row_.costs, x, costs);
      recall(row_.sums, x, sums);
      walk(costs, floor, path);
      add(path.costs, sums);
      keep(sums, row_.sums, x);
    }
  }

  HWY_INLINE void followVerticals() const {
    for (int x = row_.begin_column; x < row_.end_column; ++x) {
      Pixel costs, sums;
      if (row_.costs)
        recall(row_.costs, x, costs);
      else
        matchingCosts(x, costs);
      Path vertical;
      load(row_.straight, x, vertical);
      follow(vertical, costs, row_.floors_down[x], vertical);
      store(vertical, row_.straight, x);
      recall(row_.sums_before, x, sums);
      add(vertical.costs, sums);
      keep(sums, row_.sums, x);
    }
  }

  HWY_INLINE void walk(const Pixel& costs, uint8_t floor, Path& path) const {
    follow(path, costs, floor, path);
    path.most = hn::Add(lowestLane(d_, lowest<0, kK>(path.costs)), p2_);
  }

  HWY_INLINE void keep(const Pixel& pixel, uint8_t* row, int x) const {
    for (int k = 0; k < kK; ++k) hn::Store(pixel.v[k], d_, row + byteOf(x) + k * kLanes);
  }
  HWY_INLINE void recall(const uint8_t* row, int x, Pixel& pixel) const {
    for (int k = 0; k < kK; ++k) pixel.v[k] = hn::Load(d_, row + byteOf(x) + k * kLanes);
  }
  /// The state before the first pixel of a path: at that pixel the path costs are the matching
  /// costs.
  HWY_INLINE void start(Path& path) const {
    for (int k = 0; k < kK; ++k) path.costs.v[k] = hn::Zero(d_);
    path.most = p2_;
  }
  HWY_INLINE void load(const PathRow& source, int x, Path& path) const {
    recall(source.costs, x, path.costs);
    path.most = hn::Set(d_, source.most[x]);
  }
  HWY_INLINE void store(const Path& path, const PathRow& target, int x) const {
    keep(path.costs, target.costs, x);
    target.most[x] = static_cast<uint8_t>(lowestOfLanes(d_, lowest<0, kK>(path.costs)) + row_.p2);
  }
  HWY_INLINE void add(const Pixel& costs, Pixel& sums) const {
    for (int k = 0; k < kK; ++k) sums.v[k] = hn::SaturatedAdd(sums.v[k], costs.v[k]);
  }
  static size_t byteOf(int x) { return static_cast<size_t>(x) * kSize; }

  /// Lane by lane, the minimum of vectors kBegin ... kEnd - 1.
  template <int kBegin, int kEnd>
  static HWY_INLINE V lowest(const Pixel& pixel) {
    if constexpr (kEnd - kBegin == 1) {
      return pixel.v[kBegin];
    } else {
      constexpr int kMiddle = (kBegin + kEnd) / 2;
      return hn::Min(lowest<kBegin, kMiddle>(pixel), lowest<kMiddle, kEnd>(pixel));
    }
  }

  /// Hamming distance + P2 of every disparity.
  HWY_INLINE void matchingCosts(int x, Pixel& costs) const {
    const uint8_t* const left = row_.left_planes + x;
    const uint32_t* const offsets = row_.entry_offsets + (row_.width - 1 - x);
    V tables[kCensusNibbles];
    for (int n = 0; n < kCensusNibbles; ++n) {
      const uint8_t* rows = n == 0 ? row_.tables->distance_and_p2 : row_.tables->distance;
      tables[n] = hn::LoadDup128(d_, rows + left[n * row_.left_stride]);
    }
    for (int k = 0; k < kK; ++k) {
      V parts[kCensusNibbles];
      for (int n = 0; n < kCensusNibbles; ++n)
        parts[n] = hn::TableLookupBytes(tables[n], hn::LoadU(d_, right_[n] + offsets[k]));
      for (int n = 2; n < kCensusNibbles; n += 2) {
        parts[0] = hn::Add(parts[0], parts[n]);
        parts[1] = hn::Add(parts[1], parts[n + 1]);
      }
      costs.v[k] = hn::Add(parts[0], parts[1]);
    }
  }

  /// Eq. 1 at the next pixel: C + min(L(d), L(d +- 1) + P1, min L + P2) - min L. All terms except
  /// the last one are known before min L, which takes longest.
  HWY_INLINE void follow(const Path& previous, const Pixel& costs_and_p2, uint8_t floor,
                         Path& next) const {
    constexpr int kLast = kK - 1;
    const Pixel from = previous.costs;
    const V none = hn::Set(d_, 255), floors = hn::Set(d_, floor);
    const V below_first = lanesUp(d_, from.v[kLast], none);
    const V above_last = lanesDown(d_, from.v[0], none);
    for (int k = 0; k < kK; ++k) {
      const V below = k == 0 ? below_first : from.v[k - 1];
      const V above = k == kLast ? above_last : from.v[k + 1];
      const V carried = hn::Min(from.v[k], hn::SaturatedAdd(hn::Min(below, above), p1_));
      const V goodness = hn::Max(hn::SaturatedSub(previous.most, carried), floors);
      next.costs.v[k] = hn::Sub(costs_and_p2.v[k], goodness);
    }
    if (row_.dead)
      for (int k = 0; k < kK; ++k)
        next.costs.v[k] = hn::Or(next.costs.v[k], hn::Load(d_, row_.dead + k * kLanes));
  }

  /// The first pass writes past the caches, as a whole volume does not fit into them. The second
  /// one prefetches these sums.
  HWY_INLINE void finish(int x, Pixel& sums) const {
    uint8_t* const target = row_.sums + byteOf(x);
    if (!row_.sums_before) {
      for (int k = 0; k < kK; ++k) hn::Stream(sums.v[k], d_, target + k * kLanes);
      return;
    }
    const uint8_t* const before = row_.sums_before + byteOf(x);
    const ptrdiff_t ahead = (row_.upward ? -1 : 1) * kPrefetchedPixels * kSize;
    for (int byte = 0; byte < kSize; byte += kCacheLine) hwy::Prefetch(before + ahead + byte);
    for (int k = 0; k < kK; ++k)
      hn::Store(
          joinPasses < kStraight && kDiagonal > (sums.v[k], hn::Load(d_, before + k * kLanes)), d_,
          target + k * kLanes);
  }

  static constexpr int kCacheLine = 64;
  static constexpr int kPrefetchedPixels = 16;
  const D d_{};
  const FullSearchRow row_;
  const V p1_, p2_;
  const uint8_t* right_[kCensusNibbles];
};

template <int kK>
void aggregate(const FullSearchRow& row) {
  if (row.paths == PathSet::kStraight4) RowAggregation<kK, true, false>(row).run();
  if (row.paths == PathSet::kDiagonal4) RowAggregation<kK, false, true>(row).run();
  if (row.paths == PathSet::kAll8) RowAggregation<kK, true, true>(row).run();
}

void AggregateFullRow(const FullSearchRow& row) {
  callWithVectors(row.layout.vectors,
                  [&](auto vectors) { aggregate<decltype(vectors)::value>(row); });
}

StripedLayout LayOutStripes(int count) { return layOutStripes(count); }

#else
void AggregateFullRow(const FullSearchRow&) {}
StripedLayout LayOutStripes(int count) { return {1, count}; }
#endif

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(AggregateFullRow);
HWY_EXPORT(LayOutStripes);

StripedLayout stripedLayout(int64_t simd_target, int count) {
  return PREDICTIVE_STEREO_DISPATCH(LayOutStripes, simd_target)(count);
}
FullSearchRowFunction fullSearchRow(int64_t simd_target) {
  return PREDICTIVE_STEREO_DISPATCH(AggregateFullRow, simd_target);
}

}  // namespace predictive_stereo
#endif
