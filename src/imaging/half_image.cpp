#include "imaging/half_image.h"

#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "imaging/half_image.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

PREDICTIVE_STEREO_BEGIN_KERNELS;

/// Halves two rows.
void HalveRows(const uint8_t* upper, const uint8_t* lower, int half_width, uint8_t* half) {
  int x = 0;
#if PREDICTIVE_STEREO_HAS_VECTORS
  const hn::ScalableTag<uint16_t> d16;
  const hn::Repartition<uint8_t, decltype(d16)> d8;
  const hn::RebindToSigned<decltype(d16)> d16_signed;
  const hn::Rebind<uint8_t, decltype(d16)> d8_half;
  const auto low_byte = hn::Set(d16, 255), two = hn::Set(d16, 2);
  const auto sumsOfPairs = [&](const uint8_t* row) {
    const auto pairs = hn::BitCast(d16, hn::LoadU(d8, row + 2 * x));
    return hn::Add(hn::And(pairs, low_byte), hn::ShiftRight<8>(pairs));
  };
  const int lanes = static_cast<int>(hn::Lanes(d16));
  for (; x + lanes <= half_width; x += lanes) {
    const auto sums = hn::Add(sumsOfPairs(upper), sumsOfPairs(lower));
    const auto means = hn::BitCast(d16_signed, hn::ShiftRight<2>(hn::Add(sums, two)));
    hn::StoreU(hn::DemoteTo(d8_half, means), d8_half, half + x);
  }
#endif
  for (; x < half_width; ++x) {
    const int sum = upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1];
    half[x] = static_cast<uint8_t>((sum + 2) / 4);
  }
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(HalveRows);

void halveImage(const cv::Mat1b& image, int64_t simd_target, cv::Mat1b& half) {
  half.create(image.rows / 2, image.cols / 2);
  const auto halveRows = PREDICTIVE_STEREO_DISPATCH(HalveRows, simd_target);
  parallelForEach(half.rows,
                  [&](int y) { halveRows(image[2 * y], image[2 * y + 1], half.cols, half[y]); });
}

}  // namespace predictive_stereo
#endif
