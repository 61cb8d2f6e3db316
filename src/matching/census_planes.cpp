#include "matching/census_planes.h"

#include <algorithm>

#include "matching/census.h"
#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/census_planes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

#if PREDICTIVE_STEREO_HAS_VECTORS

namespace hn = hwy::HWY_NAMESPACE;

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

#else
void SplitIntoTableRows(const int*, int, size_t, uint8_t*) {}
void SplitIntoIndices(const int*, int, size_t, uint8_t*) {}
#endif

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(SplitIntoTableRows);
HWY_EXPORT(SplitIntoIndices);

/// Whole cache lines, with room to read and write whole vectors.
size_t paddedStride(int entries) {
  constexpr int kLargestVector = 64;
  return (entries + kLargestVector + 63) / 64 * 64;
}

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

}  // namespace predictive_stereo
#endif
