/// The layout of the full search (full_kernel.h) on one SIMD target. Included once per target.

#if defined(PREDICTIVE_STEREO_STRIPED_LAYOUT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PREDICTIVE_STEREO_STRIPED_LAYOUT_INL_H_
#undef PREDICTIVE_STEREO_STRIPED_LAYOUT_INL_H_
#else
#define PREDICTIVE_STEREO_STRIPED_LAYOUT_INL_H_
#endif

#include <hwy/highway.h>

#include <type_traits>

#include "matching/full_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

#if PREDICTIVE_STEREO_HAS_VECTORS

namespace hn = hwy::HWY_NAMESPACE;

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

#endif

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#endif
