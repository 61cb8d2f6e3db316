#include "predictive_stereo/post_filter.h"

#include <algorithm>
#include <array>
#include <limits>

#include "filtering/create_apart.h"
#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/post_filter.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "simd/pixel_loop-inl.h"

#ifndef PREDICTIVE_STEREO_POST_FILTER_KEY
#define PREDICTIVE_STEREO_POST_FILTER_KEY
namespace predictive_stereo {

/// Key of unknown pixels, and of pixels outside the image: it is never between two others.
constexpr int32_t kNoSupportKey = INT32_MIN;

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

// Floats as integers of the same order; 0 and -0 give different integers.
template <class D>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> orderedKeys(D, hn::Vec<D> value) {
  const hn::RebindToSigned<D> di;
  const hn::RebindToUnsigned<D> du;
  const auto bits = hn::BitCast(di, value);
  const auto sign = hn::BitCast(du, hn::BroadcastSignBit(bits));
  return hn::Xor(bits, hn::BitCast(di, hn::ShiftRight<1>(sign)));
}

// Keys for the support test: integers in the order of the disparities. One subtraction and one
// comparison then decide whether a disparity is between two others.
void supportKeysOfRow(const float* disparity_px, int width, float smallest_valid, int32_t* keys) {
  forPixels<float>(0, width, [=](auto d, int x) HWY_ATTR {
    const hn::RebindToSigned<decltype(d)> di;
    const auto value = hn::LoadU(d, disparity_px + x);
    const auto valid = hn::RebindMask(di, hn::Ge(value, hn::Set(d, smallest_valid)));
    const auto key = orderedKeys(d, hn::Add(value, hn::Zero(d)));  // -0 becomes 0
    hn::StoreU(hn::IfThenElse(valid, key, hn::Set(di, kNoSupportKey)), di, keys + x);
  });
}

// One output row of filterBySupport. `keys` are those of the rows from two above to two below, with
// two more entries on both sides.
void filterRowBySupport(const float* disparity_px, const int32_t* const keys[5], int width,
                        float smallest_valid, float invalid, int min_support, float* filtered) {
  forPixels<float>(0, width, [=](auto d, int x) HWY_ATTR {
    const hn::RebindToSigned<decltype(d)> di;
    const auto smallest = hn::Set(d, smallest_valid), one = hn::Set(d, 1.f);
    const auto sign = hn::Set(di, INT32_MIN), too_many = hn::Set(di, min_support - 26);
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
  });
}

void leaveOutAmbiguousOfRow(const float* HWY_RESTRICT measured_px,
                            const uint8_t* HWY_RESTRICT ambiguity,
                            const float* HWY_RESTRICT disparity_px, int width, float smallest_valid,
                            float invalid, int most, float* HWY_RESTRICT certain_px) {
  for (int x = 0; x < width; ++x) {
    const bool left_out = (measured_px[x] >= smallest_valid) & (ambiguity[x] > most);
    const float disparity = disparity_px[x];
    certain_px[x] = left_out ? invalid : disparity;
  }
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

// One output row of the 3x3 median. `rows` are the input rows from one above to one below, with one
// more pixel on both sides; pixels outside the image are invalid.
void medianOfRow(const float* const rows[3], int width, float smallest_valid, float invalid,
                 int fewest, float* filtered) {
  forPixels<float>(0, width, [=](auto d, int x) HWY_ATTR {
    using V = hn::Vec<decltype(d)>;
    const V smallest = hn::Set(d, smallest_valid);
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
      return;
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
    const auto known =
        hn::Or(centre_valid, hn::Ge(valid_count, hn::Set(d, static_cast<float>(fewest))));
    hn::StoreU(hn::IfThenElse(known, medianOfNine(v), hn::Set(d, invalid)), d, filtered + x);
  });
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(supportKeysOfRow);
HWY_EXPORT(filterRowBySupport);
HWY_EXPORT(leaveOutAmbiguousOfRow);
HWY_EXPORT(medianOfRow);

// Calls prepare(y, row) for every row of an image, then kernel(y, rows) with the prepared rows from
// y - kReach to y + kReach while they are in the cache. Rows and columns outside the image are
// `outside`.
template <int kReach, class T, class Prepare, class Kernel>
void filterRows(cv::Size size, T outside, const Prepare& prepare, const Kernel& kernel) {
  constexpr int kBandRows = 32, kRows = 2 * kReach + 1;
  const int bands = (size.height + kBandRows - 1) / kBandRows;
  const int step = size.width + 2 * kReach;
  parallelFor(cv::Range(0, bands), [&](const cv::Range& part) {
    cv::AutoBuffer<T, (kRows + 1) * 2048> memory(static_cast<size_t>((kRows + 1) * step));
    std::fill_n(memory.data(), memory.size(), outside);
    const auto row = [&](int y) {
      const int place = y < 0 || y >= size.height ? kRows : y % kRows;
      return memory.data() + place * step + kReach;
    };
    for (int band = part.start; band < part.end; ++band) {
      const int begin = band * kBandRows, end = std::min(begin + kBandRows, size.height);
      int next = std::max(begin - kReach, 0);  // first row that is not prepared yet
      for (int y = begin; y < end; ++y) {
        for (; next <= std::min(y + kReach, size.height - 1); ++next) prepare(next, row(next));
        std::array<const T*, kRows> rows;
        for (int i = 0; i < kRows; ++i) rows[i] = row(y + i - kReach);
        kernel(y, rows.data());
      }
    }
  });
}

}  // namespace

void filterBySupport(const DisparityRange& range, int min_support, const cv::Mat1f& disparity_px,
                     cv::Mat1f& filtered_px) {
  createApart("filterBySupport", disparity_px, filtered_px);
  const cv::Size size = disparity_px.size();
  const auto smallest_valid = static_cast<float>(range.min_disparity);
  filterRows<2>(
      size, kNoSupportKey,
      [&](int y, int32_t* keys) {
        HWY_DYNAMIC_DISPATCH(supportKeysOfRow)(disparity_px[y], size.width, smallest_valid, keys);
      },
      [&](int y, const int32_t* const* keys) {
        HWY_DYNAMIC_DISPATCH(filterRowBySupport)
        (disparity_px[y], keys, size.width, smallest_valid, range.invalid(), min_support,
         filtered_px[y]);
      });
}

void leaveOutAmbiguous(const DisparityRange& range, const cv::Mat1f& measured_px,
                       const cv::Mat1b& ambiguity, double most, const cv::Mat1f& disparity_px,
                       cv::Mat1f& certain_px) {
  createApart("leaveOutAmbiguous", measured_px, certain_px);
  createApart("leaveOutAmbiguous", disparity_px, certain_px);
  const auto smallest_valid = static_cast<float>(range.min_disparity);
  parallelForEach(disparity_px.rows, [&](int y) {
    HWY_DYNAMIC_DISPATCH(leaveOutAmbiguousOfRow)
    (measured_px[y], ambiguity[y], disparity_px[y], disparity_px.cols, smallest_valid,
     range.invalid(), static_cast<int>(255 * most), certain_px[y]);
  });
}

void median3x3(const DisparityRange& range, int fewest, const cv::Mat1f& disparity_px,
               cv::Mat1f& filtered_px) {
  createApart("median3x3", disparity_px, filtered_px);
  const cv::Size size = disparity_px.size();
  const auto smallest_valid = static_cast<float>(range.min_disparity);
  filterRows<1>(
      size, range.invalid(),
      [&](int y, float* row) { std::copy_n(disparity_px[y], size.width, row); },
      [&](int y, const float* const* rows) {
        HWY_DYNAMIC_DISPATCH(medianOfRow)
        (rows, size.width, smallest_valid, range.invalid(), fewest, filtered_px[y]);
      });
}

}  // namespace predictive_stereo
#endif
