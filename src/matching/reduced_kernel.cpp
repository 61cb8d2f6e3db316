#include "matching/reduced_kernel.h"

#include <algorithm>
#include <cstring>

#include "matching/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/reduced_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "matching/path_step-inl.h"

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

#if PREDICTIVE_STEREO_HAS_VECTORS

namespace hn = hwy::HWY_NAMESPACE;
using Bytes16 = hn::FixedTag<uint8_t, 16>;
using V = hn::Vec<Bytes16>;

constexpr int kLanes = 16;
constexpr int kMostVectors = 256 / kLanes;

/// Shuffles that shift by -18 ... 18 lanes are 16 bytes of this, from kNoShift - 18 on.
constexpr int kNoShift = 18;
struct ShiftTable {
  constexpr ShiftTable() {
    for (uint8_t& value : values) value = 0x80;
    for (int i = 0; i < kLanes; ++i) values[kNoShift + i] = static_cast<uint8_t>(i);
  }
  uint8_t values[2 * kNoShift + kLanes] = {};
};
constexpr ShiftTable kShiftTable;

/// A previous pixel of a path.
struct Neighbour {
  const uint8_t* goodness;
  int first;
  int width;  ///< 0: the path starts anew
};

/// What a neighbour passes on to the 16 disparities of a vector.
struct Carried {
  V same, below, above;
};

template <int kNibbles, bool kStraight, bool kDiagonal>
class RowAggregation {
 public:
  explicit RowAggregation(const ReducedSearchRow& row)
      : row_(row),
        p1_(hn::Set(d_, static_cast<uint8_t>(row.p1))),
        p2_(hn::Set(d_, static_cast<uint8_t>(row.p2))) {
    for (int n = 0; n < kNibbles; ++n) right_[n] = row.right_planes + n * row.right_stride;
  }

  HWY_INLINE void run() {
    const int step = row_.upward ? -1 : 1;
    int x = row_.upward ? row_.columns - 1 : 0;
    for (int i = 0; i < row_.columns; ++i, x += step) {
      const int width = row_.windows.width[x];
      if (width == kLanes)
        narrowPixel(x, step);
      else if (width > 0)
        widePixel(x, step, width);
      horizontal_width_ = width;
      horizontal_first_ = row_.windows.first[x];
    }
  }

 private:
  Neighbour inPreviousRow(int x, const uint8_t* goodness) const {
    const WindowRow& windows = row_.previous_windows;
    if (!windows.width || x < 0 || x >= row_.columns || windows.width[x] == 0)
      return {nullptr, 0, 0};
    return {goodness + windows.position[x], windows.first[x], windows.width[x]};
  }
  Neighbour inThisRow() const { return {horizontal_, horizontal_first_, horizontal_width_}; }

  /// Hamming distances + P2 of 16 disparities from `index` on.
  HWY_INLINE V matchingCosts(int x, int index) const {
    const uint8_t* const left = row_.left_planes + x;
    const size_t entry = row_.columns - 1 - x + index;
    V parts[kNibbles];
    for (int n = 0; n < kNibbles; ++n) {
      const auto* rows = n == 0 ? row_.tables->distance_and_p2 : row_.tables->distance;
      const V table = hn::Load(d_, rows[0] + left[n * row_.left_stride]);
      parts[n] = hn::TableLookupBytes(table, hn::LoadU(d_, right_[n] + entry));
    }
    for (int n = 2; n < kNibbles; n += 2) {
      parts[0] = hn::Add(parts[0], parts[n]);
      parts[1] = hn::Add(parts[1], parts[n + 1]);
    }
    return hn::Add(parts[0], parts[1]);
  }

  /// A window of 16.
  HWY_INLINE void narrowPixel(int x, int step) {
    const int first = row_.windows.first[x];
    const size_t at = row_.windows.position[x];
    const V costs = matchingCosts(x, first);
    V sums = hn::Zero(d_);
    if constexpr (kStraight) {
      const Carried carried = horizontal_width_ == kLanes
                                  ? shifted(horizontal_vector_, first - horizontal_first_)
                                  : fetch(inThisRow(), first);
      horizontal_vector_ = narrowPath(carried, costs, sums);
      hn::Store(horizontal_vector_, d_, horizontal_);
      const V goodness =
          narrowPath(fetch(inPreviousRow(x, row_.previous.straight), first), costs, sums);
      hn::StoreU(goodness, d_, row_.next.straight + at);
    }
    if constexpr (kDiagonal) {
      V goodness =
          narrowPath(fetch(inPreviousRow(x - step, row_.previous.from_behind), first), costs, sums);
      hn::StoreU(goodness, d_, row_.next.from_behind + at);
      goodness =
          narrowPath(fetch(inPreviousRow(x + step, row_.previous.from_ahead), first), costs, sums);
      hn::StoreU(goodness, d_, row_.next.from_ahead + at);
    }
    if (row_.sums_before) sums = hn::SaturatedAdd(sums, hn::LoadU(d_, row_.sums_before + at));
    hn::StoreU(sums, d_, row_.sums + at);
  }

  HWY_INLINE V narrowPath(const Carried& carried, V costs, V& sums) const {
    const V path = pathCost(costs, carried.same, carried.below, carried.above, p1_);
    sums = hn::SaturatedAdd(sums, path);
    return hn::SaturatedSub(p2_, hn::Sub(path, lowestLane(d_, path)));
  }

  /// For 16 disparities from `first` on.
  HWY_INLINE Carried fetch(const Neighbour& neighbour, int first) {
    if (HWY_LIKELY(neighbour.width == kLanes))
      return shifted(hn::LoadU(d_, neighbour.goodness), first - neighbour.first);
    if (neighbour.width == 0) return {p2_, p2_, p2_};
    paint(neighbour);
    const Carried carried = fromCanvas(first);
    erase(neighbour);
    return carried;
  }

  /// Lane i + shift of a window of 16, 0 where that does not exist.
  HWY_INLINE Carried shifted(V goodness, int shift) const {
    // Windows that are further apart than 16 do not even touch.
    constexpr int kApart = kLanes + 1;
    const uint8_t* shuffle = kShiftTable.values + kNoShift + std::clamp(shift, -kApart, kApart);
    return {hn::TableLookupBytesOr0(goodness, hn::LoadU(d_, shuffle)),
            hn::TableLookupBytesOr0(goodness, hn::LoadU(d_, shuffle - 1)),
            hn::TableLookupBytesOr0(goodness, hn::LoadU(d_, shuffle + 1))};
  }

  /// A window of any width.
  HWY_NOINLINE void widePixel(int x, int step, int width) {
    const int first = row_.windows.first[x];
    const size_t at = row_.windows.position[x];
    const int vectors = width / kLanes;
    V costs[kMostVectors], sums[kMostVectors];
    for (int k = 0; k < vectors; ++k) {
      costs[k] = matchingCosts(x, first + k * kLanes);
      sums[k] = hn::Zero(d_);
    }
    if constexpr (kStraight) {
      widePath(inThisRow(), first, vectors, costs, sums, horizontal_);
      widePath(inPreviousRow(x, row_.previous.straight), first, vectors, costs, sums,
               row_.next.straight + at);
    }
    if constexpr (kDiagonal) {
      widePath(inPreviousRow(x - step, row_.previous.from_behind), first, vectors, costs, sums,
               row_.next.from_behind + at);
      widePath(inPreviousRow(x + step, row_.previous.from_ahead), first, vectors, costs, sums,
               row_.next.from_ahead + at);
    }
    for (int k = 0; k < vectors; ++k) {
      if (row_.sums_before)
        sums[k] = hn::SaturatedAdd(sums[k], hn::LoadU(d_, row_.sums_before + at + k * kLanes));
      hn::StoreU(sums[k], d_, row_.sums + at + k * kLanes);
    }
  }

  HWY_INLINE void widePath(const Neighbour& neighbour, int first, int vectors, const V* costs,
                           V* sums, uint8_t* next) {
    V path[kMostVectors];
    V lowest = hn::Set(d_, 255);
    if (neighbour.width > 0) paint(neighbour);
    for (int k = 0; k < vectors; ++k) {
      const Carried carried =
          neighbour.width > 0 ? fromCanvas(first + k * kLanes) : Carried{p2_, p2_, p2_};
      path[k] = pathCost(costs[k], carried.same, carried.below, carried.above, p1_);
      lowest = hn::Min(lowest, path[k]);
      sums[k] = hn::SaturatedAdd(sums[k], path[k]);
    }
    if (neighbour.width > 0) erase(neighbour);
    lowest = lowestLane(d_, lowest);
    for (int k = 0; k < vectors; ++k)
      hn::StoreU(hn::SaturatedSub(p2_, hn::Sub(path[k], lowest)), d_, next + k * kLanes);
  }

  // The canvas holds the goodness of every disparity index, 0 but for one neighbour's window.
  HWY_INLINE void paint(const Neighbour& neighbour) {
    for (int k = 0; k < neighbour.width; k += kLanes)
      hn::StoreU(hn::LoadU(d_, neighbour.goodness + k), d_,
                 canvas_ + kMargin + neighbour.first + k);
  }
  HWY_INLINE void erase(const Neighbour& neighbour) {
    for (int k = 0; k < neighbour.width; k += kLanes)
      hn::StoreU(hn::Zero(d_), d_, canvas_ + kMargin + neighbour.first + k);
  }
  HWY_INLINE Carried fromCanvas(int index) const {
    const uint8_t* same = canvas_ + kMargin + index;
    return {hn::LoadU(d_, same), hn::LoadU(d_, same - 1), hn::LoadU(d_, same + 1)};
  }

  static constexpr int kMargin = kLanes;

  const Bytes16 d_{};
  const ReducedSearchRow row_;
  const V p1_, p2_;
  const uint8_t* right_[kNibbles];
  V horizontal_vector_ = hn::Zero(d_);  ///< goodness of the pixel before, where its window is 16
  int horizontal_first_ = 0, horizontal_width_ = 0;
  HWY_ALIGN uint8_t horizontal_[256];  ///< the same, for every width
  HWY_ALIGN uint8_t canvas_[kMargin + 256 + kMargin] = {};
};

template <int kNibbles>
void aggregate(const ReducedSearchRow& row) {
  if (row.paths == PathSet::kStraight4) RowAggregation<kNibbles, true, false>(row).run();
  if (row.paths == PathSet::kDiagonal4) RowAggregation<kNibbles, false, true>(row).run();
  if (row.paths == PathSet::kAll8) RowAggregation<kNibbles, true, true>(row).run();
}

void AggregateReducedRow(const ReducedSearchRow& row) {
  row.nibbles == 6 ? aggregate<6>(row) : aggregate<8>(row);
}

#else
void AggregateReducedRow(const ReducedSearchRow&) {}
#endif

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(AggregateReducedRow);

ReducedSearchRowFunction reducedSearchRow(int64_t simd_target) {
  return PREDICTIVE_STEREO_DISPATCH(AggregateReducedRow, simd_target);
}

}  // namespace predictive_stereo
#endif
