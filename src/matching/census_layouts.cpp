#include "matching/census_layouts.h"

#include <algorithm>
#include <cstring>

#include "matching/census.h"
#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/census_layouts.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

PREDICTIVE_STEREO_BEGIN_KERNELS;

#if PREDICTIVE_STEREO_HAS_VECTORS

/// Writes bits 4 n to 4 n + 3 of each word to target + n * stride: into the high half of the byte
/// if kHighHalf, else into the low half. Reads and writes whole vectors.
template <bool kHighHalf>
void splitWords(const int* words, int size, size_t stride, uint8_t* target) {
  const hn::ScalableTag<uint8_t> d;
  const hn::Repartition<uint16_t, decltype(d)> d16;
  const auto half = hn::Set(d, kHighHalf ? 0xF0 : 0x0F);
  for (int i = 0; i < size; i += static_cast<int>(hn::Lanes(d))) {
    const auto store = [&](int nibble, auto even, auto odd) {
      hn::StoreU(hn::And(hn::BitCast(d, even), half), d, target + i + nibble * stride);
      hn::StoreU(hn::And(hn::BitCast(d, odd), half), d, target + i + (nibble + 1) * stride);
    };
    const auto split = [&](int nibble, auto bytes) {
      const auto pairs = hn::BitCast(d16, bytes);
      if constexpr (kHighHalf)
        store(nibble, hn::ShiftLeft<4>(pairs), pairs);
      else
        store(nibble, pairs, hn::ShiftRight<4>(pairs));
    };
    hn::Vec<decltype(d)> byte0, byte1, byte2, byte3;
    hn::LoadInterleaved4(d, reinterpret_cast<const uint8_t*>(words + i), byte0, byte1, byte2,
                         byte3);
    split(0, byte0);
    split(2, byte1);
    split(4, byte2);
  }
}

void SplitIntoTableRows(const int* words, int size, size_t stride, uint8_t* target) {
  splitWords<true>(words, size, stride, target);
}
void SplitIntoIndices(const int* words, int size, size_t stride, uint8_t* target) {
  splitWords<false>(words, size, stride, target);
}

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
void SplitIntoTableRows(const int*, int, size_t, uint8_t*) {}
void SplitIntoIndices(const int*, int, size_t, uint8_t*) {}
void SplitReversed(const int*, int, size_t, uint8_t*) {}
#endif

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(SplitIntoTableRows);
HWY_EXPORT(SplitIntoIndices);
HWY_EXPORT(SplitReversed);

constexpr int kLargestVector = 64;

/// Whole cache lines, with room to read and write whole vectors.
size_t paddedStride(int entries) { return (entries + kLargestVector + 63) / 64 * 64; }

/// ordered[i] = source[x - i step] for `count` entries; columns outside the image repeat its
/// border.
void orderPhase(const int* source, int width, int x, int step, int count, int* ordered) {
  const int beyond = std::min(std::max(x - (width - 1) + step - 1, 0) / step, count);
  const int inside_end = x < 0 ? beyond : std::max(std::min(x / step + 1, count), beyond);
  std::fill_n(ordered, beyond, source[width - 1]);
  if (step == 1)
    for (int i = beyond; i < inside_end; ++i) ordered[i] = source[x - i];
  else
    for (int i = beyond; i < inside_end; ++i) ordered[i] = source[x - i * step];
  std::fill(ordered + inside_end, ordered + count, source[0]);
}

}  // namespace

void CensusPlanes::buildLeft(const cv::Mat1i& words) {
  const auto split = PREDICTIVE_STEREO_DISPATCH(SplitIntoTableRows, simd_target_);
  plane_stride_ = paddedStride(words.cols);
  planes_.create(words.rows, static_cast<int>(plane_stride_) * kCensusNibbles);
  ordered_.create(words.rows, static_cast<int>(plane_stride_));
  parallelForEach(words.rows, [&](int y) {
    std::copy_n(words[y], words.cols, ordered_[y]);
    split(ordered_[y], words.cols, plane_stride_, planes_[y]);
  });
}

void CensusPlanes::buildRight(const cv::Mat1i& words, const DisparityRange& shifts, int phases) {
  const auto split = PREDICTIVE_STEREO_DISPATCH(SplitIntoIndices, simd_target_);
  const int width = words.cols;
  const int entries = width - 1 + shifts.count;
  const int per_phase = (entries + phases - 1) / phases;
  const size_t phase_stride = paddedStride(per_phase);
  plane_stride_ = phase_stride * phases;
  entry_offsets_.resize(entries);
  for (int entry = 0; entry < entries; ++entry)
    entry_offsets_[entry] = static_cast<uint32_t>(entry % phases * phase_stride + entry / phases);
  planes_.create(words.rows, static_cast<int>(plane_stride_) * kCensusNibbles);
  ordered_.create(words.rows, static_cast<int>(plane_stride_));
  parallelForEach(words.rows, [&](int y) {
    const int* const source = words[y];
    for (int phase = 0; phase < phases; ++phase)
      orderPhase(source, width, width - 1 - shifts.min_disparity - phase, phases, per_phase,
                 ordered_[y] + phase * phase_stride);
    split(ordered_[y], static_cast<int>(plane_stride_) - 64, plane_stride_, planes_[y]);
  });
}

void CensusBytes::build(const cv::Mat1i& right_words, const DisparityRange& shifts) {
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
