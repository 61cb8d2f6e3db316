#include "filtering/post_filter_kernels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/post_filter_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Floats as integers of the same order; 0 and -0 give different integers.
template <class D>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> orderedKeys(D, hn::Vec<D> value) {
  const hn::RebindToSigned<D> di;
  const hn::RebindToUnsigned<D> du;
  const auto bits = hn::BitCast(di, value);
  const auto sign = hn::BitCast(du, hn::BroadcastSignBit(bits));
  return hn::Xor(bits, hn::BitCast(di, hn::ShiftRight<1>(sign)));
}

// Processes pixels from x on in whole vectors; returns the first pixel that is left over.
template <class D>
HWY_INLINE int keyPixels(D d, const float* disparity_px, int width, float smallest_valid, int x,
                         int32_t* keys) {
  const hn::RebindToSigned<D> di;
  const auto smallest = hn::Set(d, smallest_valid), zero = hn::Zero(d);
  const auto none = hn::Set(di, kNoSupportKey);
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (; x + lanes <= width; x += lanes) {
    const auto value = hn::LoadU(d, disparity_px + x);
    const auto valid = hn::RebindMask(di, hn::Ge(value, smallest));
    const auto key = orderedKeys(d, hn::Add(value, zero));  // -0 becomes 0
    hn::StoreU(hn::IfThenElse(valid, key, none), di, keys + x);
  }
  return x;
}

void supportKeysOfRow(const float* disparity_px, int width, float smallest_valid, int32_t* keys) {
  const int x = keyPixels(hn::ScalableTag<float>(), disparity_px, width, smallest_valid, 0, keys);
  keyPixels(hn::FixedTag<float, 1>(), disparity_px, width, smallest_valid, x, keys);
}

// Processes pixels from x on in whole vectors; returns the first pixel that is left over.
template <class D>
HWY_INLINE int filterPixelsBySupport(D d, const float* disparity_px, const int32_t* const keys[5],
                                     int width, float smallest_valid, float invalid,
                                     int min_support, int x, float* filtered) {
  const hn::RebindToSigned<D> di;
  const auto smallest = hn::Set(d, smallest_valid), one = hn::Set(d, 1.f);
  const auto sign = hn::Set(di, INT32_MIN), too_many = hn::Set(di, min_support - 26);
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (; x + lanes <= width; x += lanes) {
    const auto centre = hn::LoadU(d, disparity_px + x);
    const auto valid = hn::Ge(centre, smallest);
    // lowest <= key <= highest is highest - key <= highest - lowest for unsigned numbers. Vectors
    // compare signed numbers: flipping the sign bit of both sides keeps the order.
    const auto lowest = orderedKeys(d, hn::Sub(centre, one));
    const auto highest = orderedKeys(d, hn::Add(centre, one));
    const auto most = hn::Xor(hn::Sub(highest, lowest), sign), from = hn::Xor(highest, sign);
    auto strangers = hn::Zero(di);  // minus the number of pixels without support
    for (int i = 0; i < 5; ++i)
      for (int j = -2; j <= 2; ++j) {
        if (i == 2 && j == 0) continue;
        const auto distance = hn::Sub(from, hn::LoadU(di, keys[i] + x + j));
        strangers = hn::Add(strangers, hn::VecFromMask(di, hn::Gt(distance, most)));
      }
    const auto kept = hn::And(valid, hn::RebindMask(d, hn::Gt(strangers, too_many)));
    hn::StoreU(hn::IfThenElse(kept, centre, hn::Set(d, invalid)), d, filtered + x);
  }
  return x;
}

void filterRowBySupport(const float* disparity_px, const int32_t* const keys[5], int width,
                        float smallest_valid, float invalid, int min_support, float* filtered) {
  const int x = filterPixelsBySupport(hn::ScalableTag<float>(), disparity_px, keys, width,
                                      smallest_valid, invalid, min_support, 0, filtered);
  filterPixelsBySupport(hn::FixedTag<float, 1>(), disparity_px, keys, width, smallest_valid,
                        invalid, min_support, x, filtered);
}

template <class V>
HWY_INLINE void sort2(V& a, V& b) {
  const V smaller = hn::Min(a, b);
  b = hn::Max(a, b);
  a = smaller;
}

// Sorts the columns. The median of nine is then the median of three: the largest of the low row,
// the median of the middle row, and the smallest of the high row.
template <class V>
HWY_INLINE V medianOfNine(V (&v)[3][3]) {
  for (int j = 0; j < 3; ++j) {
    sort2(v[0][j], v[1][j]);
    sort2(v[1][j], v[2][j]);
    sort2(v[0][j], v[1][j]);
  }
  const auto median = [](V a, V b, V c) {
    sort2(a, b);
    return hn::Max(a, hn::Min(b, c));
  };
  const V low = hn::Max(hn::Max(v[0][0], v[0][1]), v[0][2]);
  const V high = hn::Min(hn::Min(v[2][0], v[2][1]), v[2][2]);
  return median(low, median(v[1][0], v[1][1], v[1][2]), high);
}

// Processes pixels from x on in whole vectors; returns the first pixel that is left over.
template <class D>
HWY_INLINE int medianOfPixels(D d, const float* const rows[3], int width, float smallest_valid,
                              float invalid, int x, float* filtered) {
  using V = hn::Vec<D>;
  const V smallest = hn::Set(d, smallest_valid), none = hn::Set(d, invalid);
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (; x + lanes <= width; x += lanes) {
    V v[3][3];
    V lowest = hn::LoadU(d, rows[1] + x);
    const auto centre_valid = hn::Ge(lowest, smallest);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        v[i][j] = hn::LoadU(d, rows[i] + x + j - 1);
        lowest = hn::Min(lowest, v[i][j]);
      }
    if (HWY_LIKELY(hn::AllTrue(d, hn::Ge(lowest, smallest)))) {
      hn::StoreU(medianOfNine(v), d, filtered + x);
      continue;
    }
    // Invalid neighbours are replaced alternately by the smallest and the largest value: the median
    // of the nine is then the (lower) median of the valid ones.
    V filler = hn::Set(d, -std::numeric_limits<float>::max());
    V valid_count = hn::Zero(d);
    for (auto& row : v)
      for (V& value : row) {
        const auto valid = hn::Ge(value, smallest);
        value = hn::IfThenElse(valid, value, filler);
        filler = hn::IfThenElse(valid, filler, hn::Neg(filler));
        valid_count = hn::Add(valid_count, hn::IfThenElseZero(valid, hn::Set(d, 1.f)));
      }
    const auto known = hn::Or(centre_valid, hn::Ge(valid_count, hn::Set(d, 5.f)));
    hn::StoreU(hn::IfThenElse(known, medianOfNine(v), none), d, filtered + x);
  }
  return x;
}

void medianOfRow(const float* const rows[3], int width, float smallest_valid, float invalid,
                 float* filtered) {
  const int x =
      medianOfPixels(hn::ScalableTag<float>(), rows, width, smallest_valid, invalid, 0, filtered);
  medianOfPixels(hn::FixedTag<float, 1>(), rows, width, smallest_valid, invalid, x, filtered);
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(supportKeysOfRow);
HWY_EXPORT(filterRowBySupport);
HWY_EXPORT(medianOfRow);

void supportKeysOfRow(const float* disparity_px, int width, float smallest_valid, int32_t* keys) {
  HWY_DYNAMIC_DISPATCH(supportKeysOfRow)(disparity_px, width, smallest_valid, keys);
}

void filterRowBySupport(const float* disparity_px, const int32_t* const keys[5], int width,
                        float smallest_valid, float invalid, int min_support, float* filtered) {
  HWY_DYNAMIC_DISPATCH(filterRowBySupport)
  (disparity_px, keys, width, smallest_valid, invalid, min_support, filtered);
}

void medianOfRow(const float* const rows[3], int width, float smallest_valid, float invalid,
                 float* filtered) {
  HWY_DYNAMIC_DISPATCH(medianOfRow)(rows, width, smallest_valid, invalid, filtered);
}

}  // namespace predictive_stereo
#endif
