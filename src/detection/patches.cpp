#include "detection/patches.h"

#include <limits>

namespace predictive_stereo {
namespace {

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

GreyPatch::GreyPatch(const cv::Mat1b& image, float x, float y) {
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

float GreyPatch::differenceFrom(const cv::Mat1b& image, float x, float y, float scale,
                                Brightness brightness) const {
  const float reach = kReach * scale;
  if (!inside_ || !(x >= reach && y >= reach && x + reach < static_cast<float>(image.cols - 1) &&
                    y + reach < static_cast<float>(image.rows - 1)))
    return std::numeric_limits<float>::infinity();
  float difference[kSide * kSide], sum = 0;
  int i = 0;
  for (int t = -kReach; t <= kReach; ++t)
    for (int s = -kReach; s <= kReach; ++s, ++i)
      sum += difference[i] = grey_[i] - interpolated(image, x + scale * static_cast<float>(s),
                                                     y + scale * static_cast<float>(t));
  const float mean = brightness == Brightness::kMayDiffer ? sum / (kSide * kSide) : 0.0f;
  sum = 0;
  for (i = 0; i < kSide * kSide; ++i)
    sum += information_[i] * (difference[i] - mean) * (difference[i] - mean);
  return sum / (kSide * kSide);
}

}  // namespace predictive_stereo
