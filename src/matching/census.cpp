#include "matching/census.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/census.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

PREDICTIVE_STEREO_BEGIN_KERNELS;

#if PREDICTIVE_STEREO_HAS_VECTORS

using Bytes = hn::ScalableTag<uint8_t>;
using SignedBytes = hn::RebindToSigned<Bytes>;
using BytesV = hn::Vec<Bytes>;

/// Eight comparisons of the pixels from x on: one byte per pixel.
HWY_INLINE BytesV compareEight(const int8_t* const* first, const int8_t* const* second, size_t x) {
  const Bytes d;
  const SignedBytes ds;
  BytesV bits = hn::Zero(d);
  for (int i = 0; i < 8; ++i) {
    const auto darker = hn::Lt(hn::LoadU(ds, first[i] + x), hn::LoadU(ds, second[i] + x));
    const auto bit = hn::Set(d, static_cast<uint8_t>(1 << i));
    bits = hn::Or(bits, hn::And(hn::BitCast(d, hn::VecFromMask(ds, darker)), bit));
  }
  return bits;
}

/// first[i] and second[i] point to the pixels that bit i of the row's first word compares.
void CensusRow(const int8_t* const* first, const int8_t* const* second, int width, int* words) {
  const Bytes d;
  const int step = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN int last[hn::MaxLanes(d)];
  for (int x = 0; x < width; x += step) {
    const BytesV byte0 = compareEight(first, second, x);
    const BytesV byte1 = compareEight(first + 8, second + 8, x);
    const BytesV byte2 = compareEight(first + 16, second + 16, x);
    const bool fits = x + step <= width;
    int* const target = fits ? words + x : last;
    hn::StoreInterleaved4(byte0, byte1, byte2, hn::Zero(d), d, reinterpret_cast<uint8_t*>(target));
    if (!fits) std::copy_n(last, width - x, words + x);
  }
}

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
void CensusRow(const int8_t* const*, const int8_t* const*, int, int*) {}
void SplitIntoTableRows(const int*, int, size_t, uint8_t*) {}
void SplitIntoIndices(const int*, int, size_t, uint8_t*) {}
void SplitReversed(const int*, int, size_t, uint8_t*) {}
#endif

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(CensusRow);
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

CensusPattern censusPattern(CensusForm form) {
  constexpr int kNear = 2;  // within 5x5
  CensusPattern pattern{};
  size_t size = 0;
  for (int y = -kNear; y <= kNear; ++y)
    for (int x = -kCensusMargin; x <= kCensusMargin; ++x) {
      const bool is_near = std::abs(x) <= kNear;
      const bool is_centre = y == 0 && x == 0;
      if (form == CensusForm::k5x5) {
        if (is_near && !is_centre) pattern[size++] = {x, y, 0, 0};
        continue;
      }
      const bool is_mixed = form == CensusForm::kMixed9x5;
      const bool before_centre = y < 0 || (y == 0 && x < 0);
      if (before_centre && (is_near || !is_mixed)) pattern[size++] = {x, y, -x, -y};
      // Of the far pixels every second one, and those above and below.
      const bool is_second = (x + y) % 2 == 0;
      if (is_mixed && ((!is_near && is_second) || (x == 0 && std::abs(y) == kNear)))
        pattern[size++] = {x, y, 0, 0};
    }
  return pattern;
}

void censusReference(const cv::Mat1b& image, CensusForm form, cv::Mat1i& words) {
  const CensusPattern pattern = censusPattern(form);
  const auto at = [&](int x, int y) {
    return image(std::clamp(y, 0, image.rows - 1), std::clamp(x, 0, image.cols - 1));
  };
  words.create(image.size());
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      int word = 0, bit = 0;
      for (const CensusComparison& c : pattern)
        word |= (at(x + c.first_x, y + c.first_y) < at(x + c.second_x, y + c.second_y)) << bit++;
      words(y, x) = word;
    }
}

void CensusKernel::transform(const cv::Mat1b& image, cv::Mat1i& words) {
  constexpr int kMargin = kCensusMargin;
  padded_.create(image.rows, image.cols + 2 * kMargin + kLargestVector);
  words.create(image.size());
  parallelForEach(image.rows, [&](int y) {
    const uint8_t* source = image[y];
    uint8_t* target = padded_[y];
    const int columns = image.cols;  // a copy: writes to bytes cannot alias it
    // Flipping the highest bit gives signed numbers of the same order, which x86 compares faster.
    for (int x = 0; x < columns; ++x) target[kMargin + x] = source[x] ^ 0x80;
    std::fill_n(target, kMargin, target[kMargin]);
    uint8_t* const end = target + kMargin + columns;
    std::fill_n(end, kMargin + kLargestVector, end[-1]);
  });

  const CensusPattern pattern = censusPattern(form_);
  const auto censusRow = PREDICTIVE_STEREO_DISPATCH(CensusRow, simd_target_);
  parallelForEach(image.rows, [&](int y) {
    const auto pixel = [&](int dx, int dy) {
      const uint8_t* row = padded_[std::clamp(y + dy, 0, image.rows - 1)];
      return reinterpret_cast<const int8_t*>(row + kMargin + dx);
    };
    const int8_t *first[kCensusBits], *second[kCensusBits];
    int i = 0;
    for (const CensusComparison& c : pattern) {
      first[i] = pixel(c.first_x, c.first_y);
      second[i++] = pixel(c.second_x, c.second_y);
    }
    censusRow(first, second, image.cols, words[y]);
  });
}

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
