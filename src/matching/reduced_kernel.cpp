#include "matching/reduced_kernel.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

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
/// Vectors for a run of windows of 16, one pixel per 16 lanes.
using RunBytes = hn::CappedTag<uint8_t, kWindowRun * kLanes>;
using RunVector = hn::Vec<RunBytes>;
constexpr int kPixelsOfVector = hn::MaxLanes(RunBytes()) / kLanes;
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

/// Vectors of 16 lanes side by side.
template <class D>
HWY_INLINE hn::Vec<D> joined(D d, const V* parts) {
  if constexpr (hn::MaxLanes(D()) == kLanes) {
    return parts[0];
  } else {
    const hn::Half<D> half;
    return hn::Combine(d, joined(half, parts + hn::MaxLanes(half) / kLanes), joined(half, parts));
  }
}

/// As many of the lowest lanes as D has.
template <class D, class From>
HWY_INLINE hn::Vec<D> lowLanes(D d, From from, hn::Vec<From> v) {
  if constexpr (hn::MaxLanes(D()) == hn::MaxLanes(From())) {
    return v;
  } else {
    const hn::Half<From> half;
    return lowLanes(d, half, hn::LowerHalf(half, v));
  }
}

/// Lane i takes the value of lane i - 1; lane 0 that of the last lane of the vector before.
template <class D, class Vector = hn::Vec<D>>
HWY_INLINE Vector oneUp(D d, Vector before, Vector here) {
  if constexpr (hn::MaxLanes(D()) == kLanes)
    return hn::CombineShiftRightBytes<15>(d, here, before);
  else
    return hn::CombineShiftRightBytes<15>(d, here, hn::ConcatLowerUpper(d, here, before));
}

/// Lane i takes the value of lane i + 1; the last lane that of lane 0 of the vector after.
template <class D, class Vector = hn::Vec<D>>
HWY_INLINE Vector oneDown(D d, Vector here, Vector after) {
  if constexpr (hn::MaxLanes(D()) == kLanes)
    return hn::CombineShiftRightBytes<1>(d, after, here);
  else
    return hn::CombineShiftRightBytes<1>(d, hn::ConcatLowerUpper(d, after, here), here);
}

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
        p1_(hn::Set(run_d_, static_cast<uint8_t>(row.p1))),
        p2_(hn::Set(run_d_, static_cast<uint8_t>(row.p2))) {}

  HWY_INLINE void run() {
    const int runs = (row_.columns + kWindowRun - 1) / kWindowRun;
    for (int i = 0; i < runs;) {
      if (isNarrowRun(row_.windows, runBegin(i))) {
        i = row_.upward ? narrowRuns<true>(i, runs) : narrowRuns<false>(i, runs);
      } else {
        severalWindows(runBegin(i));
        ++i;
      }
    }
  }

 private:
  /// The lowest column of the i-th run of the pass.
  int runBegin(int i) const {
    const int last = (row_.columns - 1) / kWindowRun;
    return (row_.upward ? last - i : i) * kWindowRun;
  }

  /// Whether all pixels of the run from column x on have windows of 16, which then are one window.
  bool isNarrowRun(const WindowRow& windows, int x) const {
    if (x + kWindowRun > row_.columns) return false;
    uint64_t widths;
    static_assert(sizeof widths == kWindowRun * sizeof *windows.width);
    std::memcpy(&widths, windows.width + x, sizeof widths);
    return widths == kLanes * uint64_t{0x0001000100010001};
  }

  Neighbour inPreviousRow(int x, const uint8_t* goodness) const {
    const WindowRow& windows = row_.previous_windows;
    if (!windows.width || x < 0 || x >= row_.columns || windows.width[x] == 0)
      return {nullptr, 0, 0};
    return {goodness + windows.position[x], windows.first[x], windows.width[x]};
  }
  Neighbour inThisRow() const { return {horizontal_, horizontal_first_, horizontal_width_}; }

  /// Hamming distances + P2 of the disparities from `index` on.
  template <class D>
  static HWY_INLINE hn::Vec<D> matchingCosts(D d, const ReducedSearchRow& row, int x, int index) {
    // Planes in groups of three: base, base + stride and base + 2 * stride are one address each.
    constexpr int kGroup = 3;
    const size_t left_stride = row.left_stride, right_stride = row.right_stride;
    const uint8_t* left = row.left_planes + x;
    const uint8_t* right = row.right_planes + (row.columns - 1 - x + index);
    hn::Vec<D> parts[kNibbles];
    for (int n = 0; n < kNibbles; ++n) {
      if (n > 0 && n % kGroup == 0) {
        left += kGroup * left_stride;
        right += kGroup * right_stride;
      }
      const auto* rows = n == 0 ? row.tables->distance_and_p2 : row.tables->distance;
      const auto table = hn::LoadDup128(d, rows[0] + left[n % kGroup * left_stride]);
      parts[n] = hn::TableLookupBytes(table, hn::LoadU(d, right + n % kGroup * right_stride));
    }
    for (int n = 2; n < kNibbles; n += 2) {
      parts[0] = hn::Add(parts[0], parts[n]);
      parts[1] = hn::Add(parts[1], parts[n + 1]);
    }
    return hn::Add(parts[0], parts[1]);
  }

  /// Runs of windows of 16, from the i-th of the pass as far as there are such; returns the first
  /// that is not.
  template <bool kUpward>
  HWY_INLINE int narrowRuns(int i, int runs) {
    // What the loop reads lies in local variables: bytes that it writes might, for all the compiler
    // knows, change the members of this object.
    const ReducedSearchRow row = row_;
    const int step = kUpward ? -1 : 1;
    V horizontal = hn::Load(d_, horizontal_);
    int horizontal_first = horizontal_first_;
    bool shifts_horizontally = horizontal_width_ == kLanes;
    int begin = runBegin(i);
    for (; i < runs && isNarrowRun(row.windows, begin); ++i, begin += step * kWindowRun) {
      const int first = row.windows.first[begin];
      const size_t at = row.windows.position[begin];
      V costs[kWindowRun];
      for (int k = 0; k < kWindowRun; ++k) {
        uint8_t* const kept = row.narrow_costs + kLanes * (begin + k);
        if (row.sums_before) {
          costs[k] = hn::Load(d_, kept);
        } else {
          costs[k] = matchingCosts(d_, row, begin + k, first);
          hn::Store(costs[k], d_, kept);
        }
      }
      HWY_ALIGN uint8_t vertical_paths[kWindowRun * kLanes];
      if constexpr (kStraight) narrowVerticals(row, begin, first, costs, vertical_paths);
      const auto pixel = [&](auto number) HWY_ATTR {
        constexpr int j = number;
        constexpr int k = kUpward ? kWindowRun - 1 - j : j;
        const int x = begin + k;
        V sums = hn::Zero(d_);
        if constexpr (kStraight) {
          const auto carried = j > 0 ? unshifted(horizontal)
                               : HWY_LIKELY(shifts_horizontally)
                                   ? shifted(d_, horizontal, first - horizontal_first)
                                   : fetch(inThisRow(), first);
          const V path = narrowCosts(d_, carried, costs[k]);
          horizontal = narrowGoodness(d_, path);
          sums = hn::SaturatedAdd(hn::Load(d_, vertical_paths + k * kLanes), path);
        }
        if constexpr (kDiagonal) {
          const auto follow = [&](const Neighbour& neighbour, uint8_t* next) {
            const V path = narrowCosts(d_, fetch(neighbour, first), costs[k]);
            hn::StoreU(narrowGoodness(d_, path), d_, next + at + k * kLanes);
            sums = hn::SaturatedAdd(sums, path);
          };
          follow(inPreviousRow(x - step, row.previous.from_behind), row.next.from_behind);
          follow(inPreviousRow(x + step, row.previous.from_ahead), row.next.from_ahead);
        }
        if (row.sums_before)
          sums = joinPasses < kStraight &&
                 kDiagonal > (sums, hn::LoadU(d_, row.sums_before + at + k * kLanes));
        hn::StoreU(sums, d_, row.sums + at + k * kLanes);
      };
      pixel(std::integral_constant<int, 0>());
      pixel(std::integral_constant<int, 1>());
      pixel(std::integral_constant<int, 2>());
      pixel(std::integral_constant<int, 3>());
      horizontal_first = first;
      shifts_horizontally = true;
    }
    hn::Store(horizontal, d_, horizontal_);
    horizontal_first_ = horizontal_first;
    horizontal_width_ = kLanes;
    return i;
  }

  /// The vertical paths of a run of windows of 16: they do not wait for each other, so that they
  /// fill registers of any width.
  HWY_INLINE void narrowVerticals(const ReducedSearchRow& row, int begin, int first, const V* costs,
                                  uint8_t* paths) {
    const uint8_t* const previous = row.previous.straight;
    uint8_t* const next = row.next.straight + row.windows.position[begin];
    const WindowRow& above = row.previous_windows;
    if (HWY_LIKELY(above.width && isNarrowRun(above, begin))) {
      const int shift = first - above.first[begin];
      for (int k = 0; k < kWindowRun; k += kPixelsOfVector) {
        const auto goodness = hn::LoadU(run_d_, previous + above.position[begin] + k * kLanes);
        const auto path =
            narrowCosts(run_d_, shifted(run_d_, goodness, shift), joined(run_d_, costs + k));
        hn::StoreU(narrowGoodness(run_d_, path), run_d_, next + k * kLanes);
        hn::Store(path, run_d_, paths + k * kLanes);
      }
    } else {
      for (int k = 0; k < kWindowRun; ++k) {
        const auto carried = fetch(inPreviousRow(begin + k, previous), first);
        const V path = narrowCosts(d_, carried, costs[k]);
        hn::StoreU(narrowGoodness(d_, path), d_, next + k * kLanes);
        hn::Store(path, d_, paths + k * kLanes);
      }
    }
  }

  // One step of a path for one pixel per 16 lanes: what it costs, and what it passes on.
  template <class D, class Vector = hn::Vec<D>>
  HWY_INLINE Vector narrowCosts(D d, const Carried<Vector>& carried, Vector costs) const {
    return pathCost(costs, carried.same, carried.below, carried.above, lowLanes(d, run_d_, p1_));
  }
  template <class D, class Vector = hn::Vec<D>>
  HWY_INLINE Vector narrowGoodness(D d, Vector path) const {
    return hn::SaturatedSub(lowLanes(d, run_d_, p2_), hn::Sub(path, lowestOfBlocks(d, path)));
  }

  /// For 16 disparities from `first` on.
  HWY_INLINE Carried<V> fetch(const Neighbour& neighbour, int first) {
    if (neighbour.width == kLanes)
      return shifted(d_, hn::LoadU(d_, neighbour.goodness), first - neighbour.first);
    if (neighbour.width == 0) {
      const V p2 = lowLanes(d_, run_d_, p2_);
      return {p2, p2, p2};
    }
    paint(neighbour);
    const auto carried = fromCanvas(d_, first);
    erase(neighbour);
    return carried;
  }

  /// Lane i + shift of windows of 16, 0 where that does not exist.
  template <class D, class Vector = hn::Vec<D>>
  HWY_INLINE Carried<Vector> shifted(D d, Vector goodness, int shift) const {
    // Windows that are further apart than 16 do not even touch.
    constexpr int kApart = kLanes + 1;
    const uint8_t* shuffle = kShiftTable.values + kNoShift + std::clamp(shift, -kApart, kApart);
    return {hn::TableLookupBytesOr0(goodness, hn::LoadDup128(d, shuffle)),
            hn::TableLookupBytesOr0(goodness, hn::LoadDup128(d, shuffle - 1)),
            hn::TableLookupBytesOr0(goodness, hn::LoadDup128(d, shuffle + 1))};
  }
  HWY_INLINE Carried<V> unshifted(V goodness) const {
    return {goodness, hn::ShiftLeftBytes<1>(d_, goodness), hn::ShiftRightBytes<1>(d_, goodness)};
  }

  /// Pixels of a run whose windows are not all 16.
  HWY_NOINLINE void severalWindows(int begin) {
    const int pixels = std::min(kWindowRun, row_.columns - begin);
    for (int j = 0; j < pixels; ++j) {
      const int x = begin + (row_.upward ? pixels - 1 - j : j);
      const int width = row_.windows.width[x];
      if (width > 0) widePixel(x, width);
      horizontal_width_ = width;
      horizontal_first_ = row_.windows.first[x];
    }
  }

  /// A window of any width, in the widest vectors that fit.
  HWY_INLINE void widePixel(int x, int width) {
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
      costs[k] = matchingCosts(d, row_, x, first + k * kLanesOfD);
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
    const bool same_window = neighbour.first == first && neighbour.width == vectors * kLanesOfD;
    if (!same_window && neighbour.width > 0) paint(neighbour);
    const auto zero = hn::Zero(d);
    const auto load = [&](int k) { return hn::LoadU(d, neighbour.goodness + k * kLanesOfD); };
    Vector before = zero, here = same_window ? load(0) : zero;
    for (int k = 0; k < vectors; ++k) {
      Carried<Vector> carried{p2, p2, p2};
      if (same_window) {
        const Vector after = k + 1 < vectors ? load(k + 1) : zero;
        carried = {here, oneUp(d, before, here), oneDown(d, here, after)};
        before = here;
        here = after;
      } else if (neighbour.width > 0) {
        carried = fromCanvas(d, first + k * kLanesOfD);
      }
      path[k] = pathCost(costs[k], carried.same, carried.below, carried.above, p1);
      lowest = hn::Min(lowest, path[k]);
      sums[k] = hn::SaturatedAdd(sums[k], path[k]);
    }
    if (!same_window && neighbour.width > 0) erase(neighbour);
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
  const RunBytes run_d_{};
  const ReducedSearchRow row_;
  const RunVector p1_, p2_;
  /// The pixel before.
  int horizontal_first_ = 0, horizontal_width_ = 0;
  HWY_ALIGN uint8_t horizontal_[256] = {};  ///< its goodness
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
