#include "matching/census.h"

#include <algorithm>
#include <cstdlib>

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

#else
void CensusRow(const int8_t* const*, const int8_t* const*, int, int*) {}
#endif

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(CensusRow);

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
  constexpr int kLargestVector = 64;
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

}  // namespace predictive_stereo
#endif
