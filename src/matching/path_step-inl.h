/// One step of a path (eq. 1) in vectors of 8-bit costs. Included once per SIMD target.

#if defined(PREDICTIVE_STEREO_PATH_STEP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PREDICTIVE_STEREO_PATH_STEP_INL_H_
#undef PREDICTIVE_STEREO_PATH_STEP_INL_H_
#else
#define PREDICTIVE_STEREO_PATH_STEP_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

#if PREDICTIVE_STEREO_HAS_VECTORS

namespace hn = hwy::HWY_NAMESPACE;

/// The lowest of all lanes, in every lane.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V lowestLane(D d, V v) {
  if constexpr (hn::MaxLanes(D()) == 16) {
#if HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3
    // The lower one of each pair in 16 bits, then x86's minimum of eight 16-bit lanes.
    const hn::Repartition<uint16_t, D> d16;
    const auto pairs = hn::Min(v, hn::BitCast(d, hn::ShiftRight<8>(hn::BitCast(d16, v))));
    return hn::TableLookupBytes(V{_mm_minpos_epu16(pairs.raw)}, hn::Zero(d));
#else
    v = hn::Min(v, hn::CombineShiftRightBytes<8>(d, v, v));
    v = hn::Min(v, hn::CombineShiftRightBytes<4>(d, v, v));
    v = hn::Min(v, hn::CombineShiftRightBytes<2>(d, v, v));
    return hn::Min(v, hn::CombineShiftRightBytes<1>(d, v, v));
#endif
  } else {
    const hn::Half<D> half;
    const auto lowest = lowestLane(half, hn::Min(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
#if HWY_TARGET == HWY_AVX2
    return V{_mm256_broadcastb_epi8(lowest.raw)};
#else
    return hn::Combine(d, lowest, lowest);
#endif
  }
}

/// 128-bit blocks moved up by one; a block of zeros comes in.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V blocksUp(D d, V v) {
  if constexpr (hn::MaxLanes(D()) == 16) {
    return hn::Zero(d);
  } else if constexpr (hn::MaxLanes(D()) == 32) {
    return hn::ConcatLowerLower(d, v, hn::Zero(d));
  } else {
    const hn::Half<D> half;
    const auto low = hn::LowerHalf(half, v), high = hn::UpperHalf(half, v);
    return hn::Combine(d, hn::ConcatLowerUpper(half, high, low), blocksUp(half, low));
  }
}

/// 128-bit blocks moved down by one; a block of zeros comes in.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V blocksDown(D d, V v) {
  if constexpr (hn::MaxLanes(D()) == 16) {
    return hn::Zero(d);
  } else if constexpr (hn::MaxLanes(D()) == 32) {
    return hn::ConcatUpperUpper(d, hn::Zero(d), v);
  } else {
    const hn::Half<D> half;
    const auto low = hn::LowerHalf(half, v), high = hn::UpperHalf(half, v);
    return hn::Combine(d, blocksDown(half, high), hn::ConcatLowerUpper(half, high, low));
  }
}

/// Lane i takes the value of lane i - 1; lane 0 becomes 0.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V lanesUp(D d, V v) {
  return hn::CombineShiftRightBytes<15>(d, v, blocksUp(d, v));
}

/// Lane i takes the value of lane i + 1; the last lane becomes 0.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V lanesDown(D d, V v) {
  return hn::CombineShiftRightBytes<1>(d, blocksDown(d, v), v);
}

/// C + P2 - max(G(d), G(d +- 1) - P1): what a path pays at disparities that have `goodness` at the
/// previous pixel, and `below` and `above` one disparity beside.
template <class V>
HWY_INLINE V pathCost(V cost_and_p2, V goodness, V below, V above, V p1) {
  const V stepped = hn::SaturatedSub(hn::Max(below, above), p1);
  return hn::Sub(cost_and_p2, hn::Max(goodness, stepped));
}

/// Sums of both passes together. Those of 8 paths are halved, as they would not fit into a byte:
/// on hard images up to a fifth of the pixels would have no winner below 255.
template <bool kHalve, class V>
HWY_INLINE V joinPasses(V sums, V sums_of_other_pass) {
  if constexpr (kHalve)
    return hn::AverageRound(sums, sums_of_other_pass);
  else
    return hn::SaturatedAdd(sums, sums_of_other_pass);
}

#endif

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#endif
