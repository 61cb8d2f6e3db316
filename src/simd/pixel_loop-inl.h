/// The loop over a row of pixels, in vectors. Included once per SIMD target.

#if defined(PREDICTIVE_STEREO_PIXEL_LOOP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PREDICTIVE_STEREO_PIXEL_LOOP_INL_H_
#undef PREDICTIVE_STEREO_PIXEL_LOOP_INL_H_
#else
#define PREDICTIVE_STEREO_PIXEL_LOOP_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

/// Calls pixels(tag, x) for x from `begin` to `end` - 1: for as many pixels at once as the tag has
/// lanes, the remaining ones one by one.
/// @param pixels  copies what it reads ([=]): compilers assume that a written byte may change what
///   a reference points to.
template <class T, class Pixels>
HWY_INLINE void forPixels(int begin, int end, const Pixels& pixels) {
  const hwy::HWY_NAMESPACE::ScalableTag<T> vectors;
  const int lanes = static_cast<int>(hwy::HWY_NAMESPACE::Lanes(vectors));
  int x = begin;
  for (; x + lanes <= end; x += lanes) pixels(vectors, x);
  for (; x < end; ++x) pixels(hwy::HWY_NAMESPACE::FixedTag<T, 1>(), x);
}

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#endif
