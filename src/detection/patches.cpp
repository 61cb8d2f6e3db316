#include "detection/patches.h"

#include <limits>

#include "detection/constants.h"

namespace predictive_stereo {
namespace {

float square(int value) { return static_cast<float>(value * value); }

// Where a row or column of samples lies between pixels: those before, and the way to the next ones.
template <int kSide>
struct Places {
  Places(float centre, float step) {
    for (int i = 0; i < kSide; ++i) {
      const float at = centre + step * static_cast<float>(i - kSide / 2);
      before[i] = static_cast<int>(at);
      beyond[i] = at - static_cast<float>(before[i]);
    }
  }
  int before[kSide];
  float beyond[kSide];
};

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
      information_[i] = 1 / (kGreyVariance + kBothFrames_px2 * gradient2);
    }
}

float GreyPatch::differenceFrom(const cv::Mat1b& image, float x, float y, float scale,
                                Brightness brightness) const {
  const float reach = kReach * scale;
  if (!inside_ || !(x >= reach && y >= reach && x + reach < static_cast<float>(image.cols - 1) &&
                    y + reach < static_cast<float>(image.rows - 1)))
    return std::numeric_limits<float>::infinity();
  const Places<kSide> columns(x, scale), rows(y, scale);
  float difference[kSide * kSide], sum = 0;
  for (int t = 0, i = 0; t < kSide; ++t) {
    const uchar *const upper = image[rows.before[t]], *const lower = image[rows.before[t] + 1];
    for (int s = 0; s < kSide; ++s, ++i) {
      const int u = columns.before[s];
      const float a = columns.beyond[s];
      const float above =
          static_cast<float>(upper[u]) + a * static_cast<float>(upper[u + 1] - upper[u]);
      const float below =
          static_cast<float>(lower[u]) + a * static_cast<float>(lower[u + 1] - lower[u]);
      sum += difference[i] = grey_[i] - (above + rows.beyond[t] * (below - above));
    }
  }
  const float mean = brightness == Brightness::kMayDiffer ? sum / (kSide * kSide) : 0.0f;
  sum = 0;
  for (int i = 0; i < kSide * kSide; ++i)
    sum += information_[i] * (difference[i] - mean) * (difference[i] - mean);
  return sum / (kSide * kSide);
}

}  // namespace predictive_stereo
