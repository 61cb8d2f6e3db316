/// Vectors of the reduced search: shifts between windows, and pairs of windows.
/// Included once per SIMD target.

#if defined(PREDICTIVE_STEREO_WINDOW_VECTORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PREDICTIVE_STEREO_WINDOW_VECTORS_INL_H_
#undef PREDICTIVE_STEREO_WINDOW_VECTORS_INL_H_
#else
#define PREDICTIVE_STEREO_WINDOW_VECTORS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "matching/census.h"
#include "matching/path_step-inl.h"
#include "matching/reduced_kernel.h"

PREDICTIVE_STEREO_BEGIN_KERNELS;

#if PREDICTIVE_STEREO_HAS_VECTORS

/// A window of 16.
using Bytes16 = hn::FixedTag<uint8_t, kNarrowWindow>;
constexpr int kLanes = kNarrowWindow;
/// Windows of 16 of neighbouring pixels, one pixel per 16 lanes.
using RunBytes = hn::CappedTag<uint8_t, kWindowRun * kLanes>;
constexpr int kPixelsOfVector = hn::MaxLanes(RunBytes()) / kLanes;
/// For windows wider than 16: 32 or more.
using WideBytes = hn::CappedTag<uint8_t, 32>;
constexpr int kWideLanes = hn::MaxLanes(WideBytes());

/// The lowest lanes of a vector: the number of lanes of D.
template <class D, class From>
HWY_INLINE hn::Vec<D> lowLanes(D d, [[maybe_unused]] From from, hn::Vec<From> v) {
  if constexpr (hn::MaxLanes(D()) == hn::MaxLanes(From())) {
    return v;
  } else {
    const hn::Half<From> half;
    return lowLanes(d, half, hn::LowerHalf(half, v));
  }
}

/// The goodness that a neighbour passes on to the disparities of a vector.
template <class V>
struct Carried {
  HWY_INLINE Carried() {}  // explicit: g++ would compile an implicit one for another target
  HWY_INLINE Carried(V from_same, V from_below, V from_above)
      : same(from_same), below(from_below), above(from_above) {}
  V same, below, above;
};

/// One step of a path (path_step-inl.h).
template <class V>
HWY_INLINE V pathCost(V cost_and_p2, const Carried<V>& carried, V p1, V floor) {
  return pathCost(cost_and_p2, carried.same, carried.below, carried.above, p1, floor);
}

/// The goodness that windows of 16 pass on.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V goodnessOf(D d, V path_costs, V p2) {
  return hn::SaturatedSub(p2, hn::Sub(path_costs, lowestOfBlocks(d, path_costs)));
}

/// Lane i gets the value of lane i - 1; lane 0 gets the last lane of the vector before.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V oneUp(D d, V before, V here) {
  if constexpr (hn::MaxLanes(D()) == kLanes)
    return hn::CombineShiftRightBytes<15>(d, here, before);
  else
    return hn::CombineShiftRightBytes<15>(d, here, hn::ConcatLowerUpper(d, here, before));
}

/// Lane i gets the value of lane i + 1; the last lane gets lane 0 of the vector after.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V oneDown(D d, V here, V after) {
  if constexpr (hn::MaxLanes(D()) == kLanes)
    return hn::CombineShiftRightBytes<1>(d, after, here);
  else
    return hn::CombineShiftRightBytes<1>(d, hn::ConcatLowerUpper(d, after, here), here);
}

/// The shuffle that shifts by s = -18 ... 18 lanes: 16 bytes of ShiftTable from kNoShift + s on.
constexpr int kNoShift = 18;
struct ShiftTable {
  constexpr ShiftTable() {
    for (uint8_t& value : values) value = 0x80;
    for (int i = 0; i < kLanes; ++i) values[kNoShift + i] = static_cast<uint8_t>(i);
  }
  uint8_t values[2 * kNoShift + kLanes] = {};
};
constexpr ShiftTable kShiftTable;

/// The shuffle that gives lane i the value of lane i + shift of a window of 16, or 0.
HWY_INLINE const uint8_t* shuffleBy(int shift) {
  // Windows with a larger distance have no neighbouring disparities.
  constexpr int kApart = kLanes + 1;
  return kShiftTable.values + kNoShift + std::clamp(shift, -kApart, kApart);
}

/// The shuffles for windows that begin `shift` disparities higher.
template <class D, class V = hn::Vec<D>>
HWY_INLINE Carried<V> shufflesBy(D d, int shift) {
  const uint8_t* const same = shuffleBy(shift);
  return {hn::LoadDup128(d, same), hn::LoadDup128(d, same - 1), hn::LoadDup128(d, same + 1)};
}

/// The goodness that windows of 16 pass on by these shuffles.
template <class V>
HWY_INLINE Carried<V> shuffled(V goodness, const Carried<V>& by) {
  return {hn::TableLookupBytesOr0(goodness, by.same), hn::TableLookupBytesOr0(goodness, by.below),
          hn::TableLookupBytesOr0(goodness, by.above)};
}

/// The goodness that windows of 16 pass on to equal windows.
template <class D, class V = hn::Vec<D>>
HWY_INLINE Carried<V> unshifted(D d, V goodness) {
  return {goodness, hn::ShiftLeftBytes<1>(d, goodness), hn::ShiftRightBytes<1>(d, goodness)};
}

/// A step function: 0 for negative positions, 255 from zero on; for positions from -512 to 575.
struct StepTable {
  constexpr StepTable() {
    for (int i = 512; i < 512 + 576; ++i) values[i] = 255;
  }
  const uint8_t* from_zero() const { return values + 512; }
  uint8_t values[512 + 576] = {};
};
constexpr StepTable kStep;

/// Shuffles that copy one byte of each pixel's kBytes bytes to all lanes of that pixel, for a run.
template <int kBytes>
struct SpreadTable {
  constexpr SpreadTable() {
    for (int b = 0; b < kBytes; ++b)
      for (int i = 0; i < kWindowRun * kLanes; ++i)
        of_byte[b][i] = static_cast<uint8_t>(i / kLanes * kBytes + b);
  }
  alignas(64) uint8_t of_byte[kBytes][kWindowRun * kLanes] = {};
};
constexpr SpreadTable<4> kSpreadWord;
constexpr SpreadTable<1> kSpreadByte;

/// 16 bytes from `source` on, then 16 bytes from source - 1 on, ...
template <class D>
HWY_INLINE hn::Vec<D> loadDescending(D d, const uint8_t* source) {
  if constexpr (hn::MaxLanes(D()) == kLanes) {
    return hn::LoadU(d, source);
  } else {
    const hn::Half<D> half;
    constexpr int kPixels = hn::MaxLanes(half) / kLanes;
    return hn::Combine(d, loadDescending(half, source - kPixels), loadDescending(half, source));
  }
}

/// Number of set bits in the kCensusBytes bytes of a word, + P2.
template <class D, class V = hn::Vec<D>>
class BitCounter {
 public:
  HWY_INLINE explicit BitCounter(int p2) {
    const D d;
    alignas(16) static constexpr uint8_t kBits[16] = {0, 1, 1, 2, 1, 2, 2, 3,
                                                      1, 2, 2, 3, 2, 3, 3, 4};
    once_ = hn::LoadDup128(d, kBits);
    once_and_p2_ = hn::Add(once_, hn::Set(d, static_cast<uint8_t>(p2)));
    twice_ = hn::Add(once_, once_);
  }

  HWY_INLINE V count(const V* bytes) const {
    // A full adder: three bits of equal weight give one of that weight and one of twice that
    // weight.
    const V first_two = hn::Xor(bytes[0], bytes[1]);
    const V ones = hn::Xor(first_two, bytes[2]);
    const V twos = hn::Or(hn::And(bytes[0], bytes[1]), hn::And(first_two, bytes[2]));
    static_assert(kCensusBytes == 3, "the full adder takes three");
    return hn::Add(hn::Add(inLow(once_and_p2_, ones), inHigh(once_, ones)),
                   hn::Add(inLow(twice_, twos), inHigh(twice_, twos)));
  }

 private:
  static HWY_INLINE V inLow(V table, V bits) {
    return hn::TableLookupBytes(table, hn::And(bits, hn::Set(D(), 0x0F)));
  }
  static HWY_INLINE V inHigh(V table, V bits) {
    const hn::Repartition<uint16_t, D> d16;
    const V shifted = hn::BitCast(D(), hn::ShiftRight<4>(hn::BitCast(d16, bits)));
    return inLow(table, shifted);
  }

  V once_, once_and_p2_, twice_;
};

/// The previous pixel of a path.
struct Neighbour {
  const uint8_t* goodness;
  int first;
  int width;  ///< 0: there is no previous pixel, the path starts here
};

/// Path steps into one window of any width. kVectors: the number of its vectors; 0: not known at
/// compile time.
template <class D, int kVectors, class V = hn::Vec<D>>
class WindowPaths {
  static constexpr int kLanesOfD = hn::MaxLanes(D());
  static constexpr int kRoom = kVectors > 0 ? kVectors : 256 / kLanesOfD;

 public:
  using Vectors = V[kRoom];
  using Passed = Carried<V>[kRoom];

  HWY_INLINE WindowPaths(const WindowRun& window, int p1, int p2)
      : first_(window.first),
        width_(window.width),
        p1_(hn::Set(D(), static_cast<uint8_t>(p1))),
        p2_(hn::Set(D(), static_cast<uint8_t>(p2))) {}

  HWY_INLINE int vectors() const { return kVectors > 0 ? kVectors : width_ / kLanesOfD; }

  /// The goodness that a neighbour passes on to this window.
  HWY_INLINE void carry(const Neighbour& neighbour, Passed& carried) const {
    const D d;
    if (neighbour.first == first_ && neighbour.width == width_) {
      Vectors goodness;
      for (int v = 0; v < vectors(); ++v)
        goodness[v] = hn::LoadU(d, neighbour.goodness + v * kLanesOfD);
      carrySameWindow(goodness, carried);
    } else if (neighbour.width > 0) {
      for (int v = 0; v < vectors(); ++v) {
        const int shift = first_ + v * kLanesOfD - neighbour.first;
        carried[v] = {insideOnly(neighbour, shift), insideOnly(neighbour, shift - 1),
                      insideOnly(neighbour, shift + 1)};
      }
    } else {
      for (int v = 0; v < vectors(); ++v) carried[v] = {p2_, p2_, p2_};
    }
  }

  /// The goodness that a neighbour with the same window passes on.
  HWY_INLINE void carrySameWindow(const Vectors& goodness, Passed& carried) const {
    const D d;
    const V zero = hn::Zero(d);
    for (int v = 0; v < vectors(); ++v)
      carried[v] = {goodness[v], oneUp(d, v > 0 ? goodness[v - 1] : zero, goodness[v]),
                    oneDown(d, goodness[v], v + 1 < vectors() ? goodness[v + 1] : zero)};
  }

  /// Adds the path's costs to `sums`, and computes the goodness that it passes on.
  HWY_INLINE void step(const Vectors& costs, const Passed& carried, uint8_t floor, Vectors& sums,
                       Vectors& goodness) const {
    const D d;
    const V floors = hn::Set(d, floor);
    Vectors path;
    V lowest = hn::Set(d, 255);
    for (int v = 0; v < vectors(); ++v) {
      path[v] = pathCost(costs[v], carried[v], p1_, floors);
      lowest = v == 0 ? path[v] : hn::Min(lowest, path[v]);
      sums[v] = hn::SaturatedAdd(sums[v], path[v]);
    }
    lowest = lowestLane(d, lowest);
    for (int v = 0; v < vectors(); ++v)
      goodness[v] = hn::SaturatedSub(p2_, hn::Sub(path[v], lowest));
  }

  HWY_INLINE void store(const Vectors& goodness, uint8_t* target) const {
    for (int v = 0; v < vectors(); ++v) hn::StoreU(goodness[v], D(), target + v * kLanesOfD);
  }

 private:
  /// Lane i: the neighbour's byte i + shift; 0 outside its window.
  static HWY_INLINE V insideOnly(const Neighbour& neighbour, int shift) {
    const D d;
    const V from_first = hn::LoadU(d, kStep.from_zero() + shift);
    const V behind_last = hn::LoadU(d, kStep.from_zero() + (shift - neighbour.width));
    return hn::AndNot(behind_last, hn::And(from_first, hn::LoadU(d, neighbour.goodness + shift)));
  }

  const int first_, width_;
  const V p1_, p2_;
};

/// Two windows of 16 in one vector, or in two if vectors have 16 lanes.
using PairBytes = hn::CappedTag<uint8_t, 2 * kLanes>;
using PairVector = hn::Vec<PairBytes>;
constexpr int kPairParts = 2 * kLanes / hn::MaxLanes(PairBytes());
struct Pair {
  HWY_INLINE Pair() {}
  PairVector parts[kPairParts];
};

template <class D, class V>
HWY_INLINE Pair pairOf([[maybe_unused]] D d, V one, V other) {
  Pair pair;
  if constexpr (hn::MaxLanes(D()) > kLanes) {
    pair.parts[0] = hn::Combine(d, other, one);
  } else {
    pair.parts[0] = one;
    pair.parts[kPairParts - 1] = other;
  }
  return pair;
}

template <class D>
HWY_INLINE Pair loadPair(D d, const uint8_t* one, const uint8_t* other) {
  return pairOf(d, hn::LoadU(Bytes16(), one), hn::LoadU(Bytes16(), other));
}

/// One value for each of the two windows, in all of its lanes.
template <class D>
HWY_INLINE Pair setPair(D d, uint8_t one, uint8_t other) {
  return pairOf(d, hn::Set(Bytes16(), one), hn::Set(Bytes16(), other));
}

template <class D>
HWY_INLINE void storePair(D d, const Pair& pair, uint8_t* one, uint8_t* other) {
  if constexpr (hn::MaxLanes(D()) > kLanes) {
    const hn::Half<D> half;
    hn::StoreU(hn::LowerHalf(half, pair.parts[0]), half, one);
    hn::StoreU(hn::UpperHalf(half, pair.parts[0]), half, other);
  } else {
    hn::StoreU(pair.parts[0], d, one);
    hn::StoreU(pair.parts[kPairParts - 1], d, other);
  }
}

/// The shuffles for pairs, with a separate shift for each window.
struct PairShuffles {
  HWY_INLINE PairShuffles(int one, int other) {
    const uint8_t *same_one = shuffleBy(one), *same_other = shuffleBy(other);
    const auto from = [&](int lane) HWY_ATTR {
      return loadPair(PairBytes(), same_one + lane, same_other + lane);
    };
    const Pair same = from(0), below = from(-1), above = from(1);
    for (int i = 0; i < kPairParts; ++i)
      of_part[i] = {same.parts[i], below.parts[i], above.parts[i]};
  }
  Carried<PairVector> of_part[kPairParts];
};

#endif

PREDICTIVE_STEREO_END_KERNELS;

#endif
