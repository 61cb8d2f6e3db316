/// The loop over a row of pixels, in vectors. Included once per SIMD target.

#if defined(PREDICTIVE_STEREO_PIXEL_LOOP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PREDICTIVE_STEREO_PIXEL_LOOP_INL_H_
#undef PREDICTIVE_STEREO_PIXEL_LOOP_INL_H_
#else
#define PREDICTIVE_STEREO_PIXEL_LOOP_INL_H_
#endif

#include <hwy/highway.h>

PREDICTIVE_STEREO_BEGIN_KERNELS;

/// Calls pixels(tag, x) for x from `begin` to `end` - 1: for as many pixels at once as the tag has
/// lanes, the remaining ones one by one.
/// @param pixels  copies what it reads ([=]): compilers assume that a written byte may change what
///   a reference points to.
template <class T, class Pixels>
HWY_INLINE void forPixels(int begin, int end, const Pixels& pixels) {
  const hn::ScalableTag<T> vectors;
  const int lanes = static_cast<int>(hn::Lanes(vectors));
  int x = begin;
  for (; x + lanes <= end; x += lanes) pixels(vectors, x);
  for (; x < end; ++x) pixels(hn::FixedTag<T, 1>(), x);
}

PREDICTIVE_STEREO_END_KERNELS;

#endif
