/// Vectors of 8-bit costs: their layout in the full search (full_kernel.h), their minimum, and one
/// step of a path (eq. 1). Included once per SIMD target.

#if defined(PREDICTIVE_STEREO_PATH_STEP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PREDICTIVE_STEREO_PATH_STEP_INL_H_
#undef PREDICTIVE_STEREO_PATH_STEP_INL_H_
#else
#define PREDICTIVE_STEREO_PATH_STEP_INL_H_
#endif

#include <hwy/highway.h>

#include <type_traits>

#include "matching/full_kernel.h"

PREDICTIVE_STEREO_BEGIN_KERNELS;

#if PREDICTIVE_STEREO_HAS_VECTORS

using StripedBytes = hn::CappedTag<uint8_t, 64>;

/// Kernels are compiled for 1 to 8 vectors per pixel, and for even numbers above.
constexpr int moreVectors(int vectors) { return vectors < 8 ? vectors + 1 : vectors + 2; }

inline StripedLayout layOutStripes(int count) {
  StripedLayout layout{static_cast<int>(hn::MaxLanes(StripedBytes())), 1};
  while (layout.size() < count) layout.vectors = moreVectors(layout.vectors);
  return layout;
}

/// Calls function(std::integral_constant<int, vectors>()).
template <int kVectors = 1, class Function>
HWY_INLINE void callWithVectors(int vectors, const Function& function) {
  constexpr int kMostDisparities = 256;
  if constexpr (kVectors * hn::MaxLanes(StripedBytes()) < kMostDisparities) {
    if (vectors > kVectors) return callWithVectors<moreVectors(kVectors)>(vectors, function);
  }
  function(std::integral_constant<int, kVectors>());
}

/// The minimum of all lanes of 16 bits, in lane 0 of the result.
template <class D, class V = hn::Vec<D>>
HWY_INLINE hn::Vec<hn::FixedTag<uint16_t, 8>> lowestWordToFront(D d, V v) {
  if constexpr (hn::MaxLanes(D()) == 8) {
#if HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3
    return V{_mm_minpos_epu16(v.raw)};
#else
    v = hn::Min(v, hn::CombineShiftRightBytes<8>(d, v, v));
    v = hn::Min(v, hn::CombineShiftRightBytes<4>(d, v, v));
    return hn::Min(v, hn::CombineShiftRightBytes<2>(d, v, v));
#endif
  } else {
    const hn::Half<D> half;
    return lowestWordToFront(half, hn::Min(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
}

/// The minimum of all lanes of 8 bits, in lane 0 of the result.
template <class D, class V = hn::Vec<D>>
HWY_INLINE hn::Vec<hn::FixedTag<uint8_t, 16>> lowestToFront(D d, V v) {
  if constexpr (hn::MaxLanes(D()) == 16) {
    const hn::Repartition<uint16_t, D> d16;
    const V pairs = hn::Min(v, hn::BitCast(d, hn::ShiftRight<8>(hn::BitCast(d16, v))));
    return hn::BitCast(d, lowestWordToFront(d16, hn::BitCast(d16, pairs)));
  } else {
    const hn::Half<D> half;
    return lowestToFront(half, hn::Min(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
}

/// The minimum of all lanes, in every lane.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V lowestLane(D d, V v) {
  const auto front = lowestToFront(d, v);
#if HWY_TARGET == HWY_AVX2
  if constexpr (hn::MaxLanes(D()) == 32) return V{_mm256_broadcastb_epi8(front.raw)};
#elif HWY_TARGET == HWY_AVX3
  if constexpr (hn::MaxLanes(D()) == 32) return V{_mm256_broadcastb_epi8(front.raw)};
  if constexpr (hn::MaxLanes(D()) == 64) return V{_mm512_broadcastb_epi8(front.raw)};
#endif
  if constexpr (hn::MaxLanes(D()) == 16)
    return hn::TableLookupBytes(front, hn::Zero(hn::FixedTag<uint8_t, 16>()));
}

/// The minimum of each 128-bit block, in every lane of the block.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V lowestOfBlocks(D d, V v) {
  if constexpr (hn::MaxLanes(D()) == 16) {
    return lowestLane(d, v);
  } else {
    v = hn::Min(v, hn::CombineShiftRightBytes<8>(d, v, v));
    v = hn::Min(v, hn::CombineShiftRightBytes<4>(d, v, v));
    v = hn::Min(v, hn::CombineShiftRightBytes<2>(d, v, v));
    return hn::Min(v, hn::CombineShiftRightBytes<1>(d, v, v));
  }
}

/// The minimum of all lanes.
template <class D, class V = hn::Vec<D>>
HWY_INLINE uint8_t lowestOfLanes(D d, V v) {
  return hn::GetLane(lowestToFront(d, v));
}

/// 128-bit blocks moved up by one; the lowest block is one of `fill`.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V blocksUp(D d, V v, V fill) {
  if constexpr (hn::MaxLanes(D()) == 16) {
    return fill;
  } else if constexpr (hn::MaxLanes(D()) == 32) {
    return hn::ConcatLowerLower(d, v, fill);
  } else {
    const hn::Half<D> half;
    const auto low = hn::LowerHalf(half, v), high = hn::UpperHalf(half, v);
    return hn::Combine(d, hn::ConcatLowerUpper(half, high, low),
                       blocksUp(half, low, hn::LowerHalf(half, fill)));
  }
}

/// 128-bit blocks moved down by one; the highest block is one of `fill`.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V blocksDown(D d, V v, V fill) {
  if constexpr (hn::MaxLanes(D()) == 16) {
    return fill;
  } else if constexpr (hn::MaxLanes(D()) == 32) {
    return hn::ConcatUpperUpper(d, fill, v);
  } else {
    const hn::Half<D> half;
    const auto low = hn::LowerHalf(half, v), high = hn::UpperHalf(half, v);
    return hn::Combine(d, blocksDown(half, high, hn::LowerHalf(half, fill)),
                       hn::ConcatLowerUpper(half, high, low));
  }
}

/// Lane i gets the value of lane i - 1; lane 0 gets that of `fill`, whose lanes are all equal.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V lanesUp(D d, V v, V fill) {
  return hn::CombineShiftRightBytes<15>(d, v, blocksUp(d, v, fill));
}

/// Lane i gets the value of lane i + 1; the last lane gets that of `fill`.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V lanesDown(D d, V v, V fill) {
  return hn::CombineShiftRightBytes<1>(d, blocksDown(d, v, fill), v);
}

/// C + P2 - max(G(d), G(d +- 1) - P1, floor): cost of a path at disparities d. The previous pixel
/// has `goodness` at d, `below` at d - 1 and `above` at d + 1. See JumpFloors for `floor`.
template <class V>
HWY_INLINE V pathCost(V cost_and_p2, V goodness, V below, V above, V p1, V floor) {
  const V stepped = hn::SaturatedSub(hn::Max(below, above), p1);
  return hn::Sub(cost_and_p2, hn::Max(hn::Max(goodness, floor), stepped));
}

/// Adds the sums of both passes. Those of 8 paths are halved, as they would not fit into a byte: on
/// difficult images up to a fifth of the pixels would have no winner below 255.
template <bool kHalve, class V>
HWY_INLINE V joinPasses(V sums, V sums_of_other_pass) {
  if constexpr (kHalve)
    return hn::AverageRound(sums, sums_of_other_pass);
  else
    return hn::SaturatedAdd(sums, sums_of_other_pass);
}

#endif

PREDICTIVE_STEREO_END_KERNELS;

#endif
