#include "matching/right_words.h"

#include <algorithm>

#include "matching/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/right_words.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

#if PREDICTIVE_STEREO_HAS_VECTORS

namespace hn = hwy::HWY_NAMESPACE;

/// Bits 4 n, ... of each word go to target + n * stride. Reads and writes up to 63 words more.
void SplitWords(const int* words, int size, int nibbles, size_t stride, uint8_t* target) {
  const hn::ScalableTag<uint8_t> d;
  const auto low_bits = hn::Set(d, 15);
  const auto high = [&](auto bytes) {
    const hn::Repartition<uint16_t, decltype(d)> d16;
    return hn::And(hn::BitCast(d, hn::ShiftRight<4>(hn::BitCast(d16, bytes))), low_bits);
  };
  for (int i = 0; i < size; i += static_cast<int>(hn::Lanes(d))) {
    hn::Vec<decltype(d)> byte0, byte1, byte2, byte3;
    hn::LoadInterleaved4(d, reinterpret_cast<const uint8_t*>(words + i), byte0, byte1, byte2,
                         byte3);
    uint8_t* const at = target + i;
    hn::StoreU(hn::And(byte0, low_bits), d, at);
    hn::StoreU(high(byte0), d, at + stride);
    hn::StoreU(hn::And(byte1, low_bits), d, at + 2 * stride);
    hn::StoreU(high(byte1), d, at + 3 * stride);
    hn::StoreU(hn::And(byte2, low_bits), d, at + 4 * stride);
    hn::StoreU(high(byte2), d, at + 5 * stride);
    if (nibbles == 6) continue;
    hn::StoreU(hn::And(byte3, low_bits), d, at + 6 * stride);
    hn::StoreU(high(byte3), d, at + 7 * stride);
  }
}

#else
void SplitWords(const int*, int, int, size_t, uint8_t*) {}
#endif

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(SplitWords);

void RightWords::build(const cv::Mat1i& words, const DisparityRange& range, int nibbles,
                       int phases) {
  constexpr int kLargestVector = 64;
  const int width = words.cols;
  const int entries = width - 1 + range.count;
  const int per_phase = (entries + phases - 1) / phases;
  stride_ = (per_phase + kLargestVector + 63) / 64 * 64;
  planes_.create(words.rows, static_cast<int>(stride_) * nibbles * phases);
  ordered_.create(words.rows, static_cast<int>(stride_) * phases);
  const auto splitWords = PREDICTIVE_STEREO_DISPATCH(SplitWords, simd_target_);
  cv::parallel_for_(cv::Range(0, words.rows), [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y)
      for (int phase = 0; phase < phases; ++phase) {
        int* const ordered = ordered_[y] + phase * stride_;
        const int* const source = words[y];
        int x = width - 1 - range.min_disparity - phase;
        for (int i = 0; i < per_phase; ++i, x -= phases)
          ordered[i] = source[std::clamp(x, 0, width - 1)];
        splitWords(ordered, per_phase, nibbles, stride_, planes_[y] + phase * nibbles * stride_);
      }
  });
}

}  // namespace predictive_stereo
#endif
