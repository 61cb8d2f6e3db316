#include "odometry/half_image.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "matching/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "odometry/half_image.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef PREDICTIVE_STEREO_HALF_IMAGE_ROWS
#define PREDICTIVE_STEREO_HALF_IMAGE_ROWS
namespace predictive_stereo {

constexpr int kReach = 2;
using SourceRows = std::array<const uint8_t*, 2 * kReach + 1>;

template <class T>
inline int smoothed(T a, T b, T c, T d, T e) {
  return a + e + 4 * (b + d) + 6 * c;
}

}  // namespace predictive_stereo
#endif

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Sums over five rows, of 16 * 255 at most.
void sumRows(const SourceRows& rows, int width, int16_t* sums) {
  int x = 0;
#if PREDICTIVE_STEREO_HAS_VECTORS
  const hn::ScalableTag<int16_t> d;
  const hn::Rebind<uint8_t, decltype(d)> d8;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (; x + lanes <= width; x += lanes) {
    const auto row = [&](size_t k)
                         HWY_ATTR { return hn::PromoteTo(d, hn::LoadU(d8, rows[k] + x)); };
    const auto inner = hn::Add(row(1), row(3)), centre = row(2);
    const auto half = hn::Add(hn::Add(inner, inner), hn::Add(centre, hn::Add(centre, centre)));
    hn::StoreU(hn::Add(hn::Add(row(0), row(4)), hn::Add(half, half)), d, sums + x);
  }
#endif
  for (; x < width; ++x)
    sums[x] =
        static_cast<int16_t>(smoothed(rows[0][x], rows[1][x], rows[2][x], rows[3][x], rows[4][x]));
}

// Means over five columns around every second one.
void halveColumns(const int16_t* sums, int width, uint8_t* half) {
  int x = 0;
#if PREDICTIVE_STEREO_HAS_VECTORS
  const hn::ScalableTag<int16_t> d16;
  const hn::RepartitionToWide<decltype(d16)> d;
  const hn::Rebind<uint8_t, decltype(d)> d8;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (; x + lanes <= width; x += lanes) {
    auto sum = hn::Set(d, 128), rest = hn::Zero(d);
    const auto addPairs = [&](int column, int even, int odd) HWY_ATTR {
      const auto pairs = hn::LoadU(d16, sums + 2 * x + column);
      const auto weights = hn::BitCast(d16, hn::Set(d, even | odd << 16));
      sum = hn::ReorderWidenMulAccumulate(d, pairs, weights, sum, rest);
    };
    addPairs(-2, 1, 4);
    addPairs(0, 6, 4);
    addPairs(2, 1, 0);
    const auto total = hn::RearrangeToOddPlusEven(sum, rest);
    hn::StoreU(hn::DemoteTo(d8, hn::ShiftRight<8>(total)), d8, half + x);
  }
#endif
  for (; x < width; ++x) {
    const int16_t* at = sums + 2 * x;
    half[x] = static_cast<uint8_t>((smoothed(at[-2], at[-1], at[0], at[1], at[2]) + 128) >> 8);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(sumRows);
HWY_EXPORT(halveColumns);

void halve(const cv::Mat1b& image, cv::Mat1b& half) {
  half.create((image.rows + 1) / 2, (image.cols + 1) / 2);
  const auto mirrored = [](int at, int size) {
    return cv::borderInterpolate(at, size, cv::BORDER_REFLECT_101);
  };
  // One more, as the last pair may have no second column.
  cv::AutoBuffer<int16_t, 4096> memory(static_cast<size_t>(image.cols + 2 * kReach + 1));
  int16_t* const sums = memory.data() + kReach;
  sums[image.cols + kReach] = 0;
  for (int y = 0; y < half.rows; ++y) {
    SourceRows rows;
    for (int k = -kReach; k <= kReach; ++k)
      rows[static_cast<size_t>(k + kReach)] = image[mirrored(2 * y + k, image.rows)];
    HWY_DYNAMIC_DISPATCH(sumRows)(rows, image.cols, sums);
    for (int k = 1; k <= kReach; ++k) {
      sums[-k] = sums[mirrored(-k, image.cols)];
      sums[image.cols - 1 + k] = sums[mirrored(image.cols - 1 + k, image.cols)];
    }
    HWY_DYNAMIC_DISPATCH(halveColumns)(sums, half.cols, half[y]);
  }
}

}  // namespace predictive_stereo
#endif
