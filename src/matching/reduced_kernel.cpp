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
constexpr int kLanes = kNarrowWindow;
/// Vectors for windows wider than 16, which are 32 or more in general.
using WideBytes = hn::CappedTag<uint8_t, 32>;
constexpr int kWideLanes = hn::MaxLanes(WideBytes());

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

/// What a neighbour passes on to the disparities of a vector.
template <class Vector>
struct Carried {
  Vector same, below, above;
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
    for (int i = 0; i < row_.columns;) {
      const int width = row_.windows.width[column(i)];
      if (width == kLanes) {
        i = narrowPixels(i);
        continue;
      }
      if (width > 0) widePixel(column(i), width);
      horizontal_width_ = width;
      horizontal_first_ = row_.windows.first[column(i)];
      ++i;
    }
  }

 private:
  /// The i-th column of the pass.
  int column(int i) const { return row_.upward ? row_.columns - 1 - i : i; }

  Neighbour inPreviousRow(int x, const uint8_t* goodness) const {
    const WindowRow& windows = row_.previous_windows;
    if (!windows.width || x < 0 || x >= row_.columns || windows.width[x] == 0)
      return {nullptr, 0, 0};
    return {goodness + windows.position[x], windows.first[x], windows.width[x]};
  }
  Neighbour inThisRow() const { return {horizontal_, horizontal_first_, horizontal_width_}; }

  /// Hamming distances + P2 of the disparities from `index` on.
  template <class D>
  HWY_INLINE hn::Vec<D> matchingCosts(D d, int x, int index) const {
    const uint8_t* const left = row_.left_planes + x;
    const size_t entry = row_.columns - 1 - x + index;
    hn::Vec<D> parts[kNibbles];
    for (int n = 0; n < kNibbles; ++n) {
      const auto* rows = n == 0 ? row_.tables->distance_and_p2 : row_.tables->distance;
      const auto table = hn::LoadDup128(d, rows[0] + left[n * row_.left_stride]);
      parts[n] = hn::TableLookupBytes(table, hn::LoadU(d, right_[n] + entry));
    }
    for (int n = 2; n < kNibbles; n += 2) {
      parts[0] = hn::Add(parts[0], parts[n]);
      parts[1] = hn::Add(parts[1], parts[n + 1]);
    }
    return hn::Add(parts[0], parts[1]);
  }

  /// Windows of 16, from the i-th column of the pass as far as there are such; returns the first
  /// column that has another.
  HWY_INLINE int narrowPixels(int i) {
    // What the loop reads lies in local variables: bytes that it writes might, for all the compiler
    // knows, change the members of this object.
    const ReducedSearchRow row = row_;
    const int step = row.upward ? -1 : 1;
    const WindowRow windows = row.windows, above = row.previous_windows;
    V horizontal = horizontal_vector_;
    int horizontal_first = horizontal_first_;
    bool is_first = horizontal_width_ != kLanes;
    int x = column(i);
    for (; i < row.columns && windows.width[x] == kLanes; ++i, x += step) {
      const int first = windows.first[x];
      const size_t at = windows.position[x];
      V costs, sums;
      if (row.sums_before) {
        costs = hn::Load(d_, row.narrow_costs + kLanes * x);
      } else {
        costs = matchingCosts(d_, x, first);
        hn::Store(costs, d_, row.narrow_costs + kLanes * x);
      }
      if constexpr (kStraight) {
        const auto carried = HWY_UNLIKELY(is_first) ? fetch(inThisRow(), first)
                                                    : shifted(horizontal, first - horizontal_first);
        horizontal = narrowPath<true>(carried, costs, sums);
        const auto vertical =
            HWY_LIKELY(above.width && above.width[x] == kLanes)
                ? shifted(hn::LoadU(d_, row.previous.straight + above.position[x]),
                          first - above.first[x])
                : fetch(inPreviousRow(x, row.previous.straight), first);
        const V goodness = narrowPath<false>(vertical, costs, sums);
        hn::StoreU(goodness, d_, row.next.straight + at);
      }
      if constexpr (kDiagonal) {
        V goodness = narrowPath<!kStraight>(
            fetch(inPreviousRow(x - step, row.previous.from_behind), first), costs, sums);
        hn::StoreU(goodness, d_, row.next.from_behind + at);
        goodness = narrowPath<false>(fetch(inPreviousRow(x + step, row.previous.from_ahead), first),
                                     costs, sums);
        hn::StoreU(goodness, d_, row.next.from_ahead + at);
      }
      if (row.sums_before)
        sums = joinPasses < kStraight && kDiagonal > (sums, hn::LoadU(d_, row.sums_before + at));
      hn::StoreU(sums, d_, row.sums + at);
      horizontal_first = first;
      is_first = false;
    }
    horizontal_vector_ = horizontal;
    hn::Store(horizontal, d_, horizontal_);
    horizontal_first_ = horizontal_first;
    horizontal_width_ = kLanes;
    return i;
  }

  /// kFirst: the path's costs begin the sums, else they are added.
  template <bool kFirst>
  HWY_INLINE V narrowPath(const Carried<V>& carried, V costs, V& sums) const {
    const V path = pathCost(costs, carried.same, carried.below, carried.above, p1_);
    sums = kFirst ? path : hn::SaturatedAdd(sums, path);
    return hn::SaturatedSub(p2_, hn::Sub(path, lowestLane(d_, path)));
  }

  /// For 16 disparities from `first` on.
  HWY_INLINE Carried<V> fetch(const Neighbour& neighbour, int first) {
    if (neighbour.width == kLanes)
      return shifted(hn::LoadU(d_, neighbour.goodness), first - neighbour.first);
    if (neighbour.width == 0) return {p2_, p2_, p2_};
    paint(neighbour);
    const auto carried = fromCanvas(d_, first);
    erase(neighbour);
    return carried;
  }

  /// Lane i + shift of a window of 16, 0 where that does not exist.
  HWY_INLINE Carried<V> shifted(V goodness, int shift) const {
    // Windows that are further apart than 16 do not even touch.
    constexpr int kApart = kLanes + 1;
    const uint8_t* shuffle = kShiftTable.values + kNoShift + std::clamp(shift, -kApart, kApart);
    return {hn::TableLookupBytesOr0(goodness, hn::LoadU(d_, shuffle)),
            hn::TableLookupBytesOr0(goodness, hn::LoadU(d_, shuffle - 1)),
            hn::TableLookupBytesOr0(goodness, hn::LoadU(d_, shuffle + 1))};
  }

  /// A window of any width, in the widest vectors that fit.
  HWY_NOINLINE void widePixel(int x, int width) {
    if (width % kWideLanes != 0) return widePixel<0>(d_, x, width);
    switch (width / kWideLanes) {
      case 1:
        return widePixel<1>(WideBytes(), x, width);
      case 2:
        return widePixel<2>(WideBytes(), x, width);
      case 4:
        return widePixel<4>(WideBytes(), x, width);
      default:
        return widePixel<0>(WideBytes(), x, width);
    }
  }

  /// kVectors: number of vectors, 0: as many as the window takes.
  template <int kVectors, class D>
  HWY_INLINE void widePixel(D d, int x, int width) {
    constexpr int kLanesOfD = hn::MaxLanes(D());
    const int vectors = kVectors > 0 ? kVectors : width / kLanesOfD;
    const int step = row_.upward ? -1 : 1;
    const int first = row_.windows.first[x];
    const size_t at = row_.windows.position[x];
    hn::Vec<D> costs[kVectors > 0 ? kVectors : 256 / kLanesOfD];
    hn::Vec<D> sums[kVectors > 0 ? kVectors : 256 / kLanesOfD];
    for (int k = 0; k < vectors; ++k) {
      costs[k] = matchingCosts(d, x, first + k * kLanesOfD);
      sums[k] = hn::Zero(d);
    }
    const auto follow = [&](const Neighbour& neighbour, uint8_t* next) {
      widePath<kVectors>(d, neighbour, first, vectors, costs, sums, next);
    };
    if constexpr (kStraight) {
      follow(inThisRow(), horizontal_);
      follow(inPreviousRow(x, row_.previous.straight), row_.next.straight + at);
    }
    if constexpr (kDiagonal) {
      follow(inPreviousRow(x - step, row_.previous.from_behind), row_.next.from_behind + at);
      follow(inPreviousRow(x + step, row_.previous.from_ahead), row_.next.from_ahead + at);
    }
    for (int k = 0; k < vectors; ++k) {
      const size_t bytes = at + k * kLanesOfD;
      if (row_.sums_before)
        sums[k] =
            joinPasses < kStraight && kDiagonal > (sums[k], hn::LoadU(d, row_.sums_before + bytes));
      hn::StoreU(sums[k], d, row_.sums + bytes);
    }
  }

  template <int kVectors, class D, class Vector = hn::Vec<D>>
  HWY_INLINE void widePath(D d, const Neighbour& neighbour, int first, int vectors,
                           const Vector* costs, Vector* sums, uint8_t* next) {
    constexpr int kLanesOfD = hn::MaxLanes(D());
    const Vector p1 = hn::Set(d, static_cast<uint8_t>(row_.p1));
    const Vector p2 = hn::Set(d, static_cast<uint8_t>(row_.p2));
    Vector path[kVectors > 0 ? kVectors : 256 / kLanesOfD];
    Vector lowest = hn::Set(d, 255);
    if (neighbour.width > 0) paint(neighbour);
    for (int k = 0; k < vectors; ++k) {
      const auto carried =
          neighbour.width > 0 ? fromCanvas(d, first + k * kLanesOfD) : Carried<Vector>{p2, p2, p2};
      path[k] = pathCost(costs[k], carried.same, carried.below, carried.above, p1);
      lowest = hn::Min(lowest, path[k]);
      sums[k] = hn::SaturatedAdd(sums[k], path[k]);
    }
    if (neighbour.width > 0) erase(neighbour);
    lowest = lowestLane(d, lowest);
    for (int k = 0; k < vectors; ++k)
      hn::StoreU(hn::SaturatedSub(p2, hn::Sub(path[k], lowest)), d, next + k * kLanesOfD);
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
  template <class D>
  HWY_INLINE Carried<hn::Vec<D>> fromCanvas(D d, int index) const {
    const uint8_t* same = canvas_ + kMargin + index;
    return {hn::LoadU(d, same), hn::LoadU(d, same - 1), hn::LoadU(d, same + 1)};
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
