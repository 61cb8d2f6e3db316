#include "matching/census_bytes.h"

#include <algorithm>
#include <cstring>

#include "matching/census.h"
#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/census_bytes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

#if PREDICTIVE_STEREO_HAS_VECTORS

namespace hn = hwy::HWY_NAMESPACE;
using Bytes = hn::ScalableTag<uint8_t>;

HWY_INLINE hn::Vec<Bytes> reversed(hn::Vec<Bytes> v) {
  const Bytes d;
  const hn::Repartition<uint16_t, Bytes> d16;
  const auto pairs = hn::Reverse(d16, hn::BitCast(d16, v));
  return hn::BitCast(d, hn::Or(hn::ShiftLeft<8>(pairs), hn::ShiftRight<8>(pairs)));
}

/// Entry e of plane b, at target + b * stride, becomes byte b of words[size - 1 - e].
void SplitReversed(const int* words, int size, size_t stride, uint8_t* target) {
  const Bytes d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto* const source = reinterpret_cast<const uint8_t*>(words);
  const auto split = [&](int e) HWY_ATTR {
    hn::Vec<Bytes> byte0, byte1, byte2, byte3;
    hn::LoadInterleaved4(d, source + 4 * (size - e - lanes), byte0, byte1, byte2, byte3);
    hn::StoreU(reversed(byte0), d, target + e);
    hn::StoreU(reversed(byte1), d, target + e + stride);
    hn::StoreU(reversed(byte2), d, target + e + 2 * stride);
  };
  if (size < lanes) {
    for (int e = 0; e < size; ++e)
      for (int b = 0; b < kCensusBytes; ++b)
        target[e + b * stride] = source[4 * (size - 1 - e) + b];
    return;
  }
  for (int e = 0; e + lanes <= size; e += lanes) split(e);
  split(size - lanes);  // the rest; overlaps the last vector
}

#else
void SplitReversed(const int*, int, size_t, uint8_t*) {}
#endif

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(SplitReversed);

void CensusBytes::build(const cv::Mat1i& right_words, const DisparityRange& shifts) {
  constexpr int kLargestVector = 64;
  const auto split = PREDICTIVE_STEREO_DISPATCH(SplitReversed, simd_target_);
  const int width = right_words.cols;
  // The last image column is entry -shifts.min_disparity.
  const int before = std::max(-shifts.min_disparity, 0);
  const int behind = std::max(shifts.max_disparity(), 0) + kLargestVector;
  plane_stride_ = before + width + behind;
  row_offset_ = before + shifts.min_disparity;
  planes_.create(right_words.rows, static_cast<int>(plane_stride_) * kCensusBytes);
  parallelForEach(right_words.rows, [&](int y) {
    split(right_words[y], width, plane_stride_, planes_[y] + before);
    for (int b = 0; b < kCensusBytes; ++b) {
      uint8_t* const plane = planes_[y] + b * plane_stride_;
      std::memset(plane, plane[before], before);
      std::memset(plane + before + width, plane[before + width - 1], behind);
    }
  });
}

}  // namespace predictive_stereo
#endif
