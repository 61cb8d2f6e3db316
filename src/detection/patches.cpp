#include "detection/patches.h"

#include <cmath>
#include <limits>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/patches.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

PREDICTIVE_STEREO_BEGIN_KERNELS;

constexpr int kSide = GreyPatch::kSide, kStride = GreyPatch::kStride;

// Sums are over rows lane by lane, then over lanes in their order, on every target.
using D = hn::CappedTag<float, kStride>;
using V = hn::Vec<D>;

HWY_INLINE float meanOfLanes(const float* lanes) {
  static_assert(kSide == 5, "written out");
  return (lanes[0] + lanes[1] + lanes[2] + lanes[3] + lanes[4]) / GreyPatch::kArea;
}

HWY_INLINE V greyAt(D d, const uint8_t* HWY_RESTRICT bytes) {
  const hn::Rebind<int32_t, D> d32;
  const hn::Rebind<uint8_t, D> d8;
  return hn::ConvertTo(d, hn::PromoteTo(d32, hn::LoadU(d8, bytes)));
}

HWY_INLINE V lineAt(D d, const uint8_t* HWY_RESTRICT bytes, V fx) {
  const V left = greyAt(d, bytes), right = greyAt(d, bytes + 1);
  return hn::Add(left, hn::Mul(fx, hn::Sub(right, left)));
}

// A patch before the mean is subtracted; returns the mean.
HWY_INLINE float between(const uint8_t* HWY_RESTRICT upper_left, std::ptrdiff_t stride, float fx,
                         float fy, float* HWY_RESTRICT grey) {
  const D d;
  const V x = hn::Set(d, fx), y = hn::Set(d, fy);
  HWY_ALIGN float columns[kStride];
  for (int i = 0; i < kStride; i += static_cast<int>(hn::Lanes(d))) {
    V upper = lineAt(d, upper_left + i, x), sum = hn::Zero(d);
    for (int v = 0; v < kSide; ++v) {
      const V lower = lineAt(d, upper_left + (v + 1) * stride + i, x);
      const V value = hn::Add(upper, hn::Mul(y, hn::Sub(lower, upper)));
      hn::StoreU(value, d, grey + kStride * v + i);
      sum = hn::Add(sum, value);
      upper = lower;
    }
    hn::Store(sum, d, columns + i);
  }
  return meanOfLanes(columns);
}

HWY_NOINLINE void patchBetween(const uint8_t* upper_left, std::ptrdiff_t stride, float fx, float fy,
                               GreyPatch& patch) {
  const float mean = between(upper_left, stride, fx, fy, patch.grey);
  for (float& grey : patch.grey) grey -= mean;
}

// Mean |difference| between `grey` - `mean` and the patch.
HWY_INLINE float meanDifference(const float* HWY_RESTRICT patch, const float* HWY_RESTRICT grey,
                                float mean) {
  const D d;
  HWY_ALIGN float columns[kStride];
  for (int i = 0; i < kStride; i += static_cast<int>(hn::Lanes(d))) {
    V sum = hn::Zero(d);
    for (int v = 0; v < kSide; ++v) {
      const V other = hn::Sub(hn::LoadU(d, grey + kStride * v + i), hn::Set(d, mean));
      sum = hn::Add(sum, hn::Abs(hn::Sub(hn::LoadU(d, patch + kStride * v + i), other)));
    }
    hn::Store(sum, d, columns + i);
  }
  return meanOfLanes(columns);
}

HWY_NOINLINE float patchDifference(const GreyPatch& patch, const uint8_t* upper_left,
                                   std::ptrdiff_t stride, float fx, float fy) {
  float grey[kSide * kStride];
  const float mean = between(upper_left, stride, fx, fy, grey);
  return meanDifference(patch.grey, grey, mean);
}

HWY_NOINLINE float patchTexture(const GreyPatch& patch) {
  const float nothing[kSide * kStride] = {};
  return meanDifference(patch.grey, nothing, 0);
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(patchBetween);
HWY_EXPORT(patchDifference);
HWY_EXPORT(patchTexture);

constexpr float kNoise_grey2 = 8;           // variance of the difference of two grey values
constexpr float kPlaceVariance_px2 = 0.5f;  // of the place, along the gradient

float square(int value) { return static_cast<float>(value * value); }

float interpolated(const cv::Mat1b& image, float x, float y) {
  const int u = static_cast<int>(x), v = static_cast<int>(y);
  const float a = x - static_cast<float>(u), b = y - static_cast<float>(v);
  const uchar *upper = image[v] + u, *lower = image[v + 1] + u;
  const float above = static_cast<float>(upper[0]) + a * static_cast<float>(upper[1] - upper[0]);
  const float below = static_cast<float>(lower[0]) + a * static_cast<float>(lower[1] - lower[0]);
  return above + b * (below - above);
}

}  // namespace

void patchBetween(const uint8_t* upper_left, std::ptrdiff_t stride, float fx, float fy,
                  GreyPatch& patch) {
  HWY_DYNAMIC_DISPATCH(patchBetween)(upper_left, stride, fx, fy, patch);
}

float patchDifference(const GreyPatch& patch, const uint8_t* upper_left, std::ptrdiff_t stride,
                      float fx, float fy) {
  return HWY_DYNAMIC_DISPATCH(patchDifference)(patch, upper_left, stride, fx, fy);
}

float patchTexture(const GreyPatch& patch) { return HWY_DYNAMIC_DISPATCH(patchTexture)(patch); }

GreyPatchOf::GreyPatchOf(const cv::Mat1b& image, float x, float y) {
  const int u = cvRound(x), v = cvRound(y);
  constexpr int kMargin = kReach + 1;  // gradients need one more pixel
  inside_ = u >= kMargin && v >= kMargin && u < image.cols - kMargin && v < image.rows - kMargin;
  if (!inside_) return;
  int i = 0;
  for (int t = v - kReach; t <= v + kReach; ++t)
    for (int s = u - kReach; s <= u + kReach; ++s, ++i) {
      const float gradient2 = 0.25f * (square(image(t, s + 1) - image(t, s - 1)) +
                                       square(image(t + 1, s) - image(t - 1, s)));
      grey_[i] = image(t, s);
      information_[i] = 1 / (kNoise_grey2 + kPlaceVariance_px2 * gradient2);
    }
}

float GreyPatchOf::differenceFrom(const cv::Mat1b& image, float x, float y, float scale) const {
  const float reach = kReach * scale;
  if (!inside_ || !(x >= reach && y >= reach && x + reach < static_cast<float>(image.cols - 1) &&
                    y + reach < static_cast<float>(image.rows - 1)))
    return std::numeric_limits<float>::infinity();
  float sum = 0;
  int i = 0;
  for (int t = -kReach; t <= kReach; ++t)
    for (int s = -kReach; s <= kReach; ++s, ++i) {
      const float difference = grey_[i] - interpolated(image, x + scale * static_cast<float>(s),
                                                       y + scale * static_cast<float>(t));
      sum += information_[i] * difference * difference;
    }
  return sum / (kSide * kSide);
}

}  // namespace predictive_stereo
#endif
