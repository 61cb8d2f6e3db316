#include "predictive_stereo/photometric_residual.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace predictive_stereo {
namespace {

const DisparityRange kRange{0, 32};

cv::Size mapSize(cv::Size size) {
  const double step = kResidualStep;
  return {cvCeil(size.width / step), cvCeil(size.height / step)};
}

struct Pair {
  Pair(cv::Size size, cv::RNG& rng) : left(size), right(size), disparity_px(size) {
    rng.fill(left, cv::RNG::UNIFORM, 0, 256);
    rng.fill(right, cv::RNG::UNIFORM, 0, 256);
    rng.fill(disparity_px, cv::RNG::UNIFORM, -6.0f, 20.0f);
    disparity_px.setTo(kRange.invalid(), disparity_px < 0);
  }
  cv::Mat1f measure(double principal_offset_px = 0) const {
    cv::Mat1f share;
    PhotometricResidual().measure(left, right, disparity_px, kRange, principal_offset_px, share);
    return share;
  }
  cv::Mat1b left, right;
  cv::Mat1f disparity_px;
};

/// Left brightness and left - right at the match, if there is one.
std::vector<cv::Vec2d> matchAt(const Pair& pair, int x, int y, double principal_offset_px) {
  if (x < 0 || y < 0 || x >= pair.left.cols || y >= pair.left.rows) return {};
  if (!kRange.isValid(pair.disparity_px(y, x))) return {};
  const double match = std::nearbyint(x - pair.disparity_px(y, x) - principal_offset_px);
  if (match < 0 || match >= pair.right.cols) return {};
  const double left = pair.left(y, x);
  return {{left, left - pair.right(y, static_cast<int>(match))}};
}

/// Standard deviations of both over the window of 5x5 pixels around (x, y).
cv::Vec2d deviationsNaively(const Pair& pair, int x, int y, double principal_offset_px) {
  std::vector<cv::Vec2d> matches;
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx)
      for (const cv::Vec2d& match :
           matchAt(pair, x + kResidualStep * dx, y + kResidualStep * dy, principal_offset_px))
        matches.push_back(match);
  if (matches.empty()) return {};
  cv::Scalar mean, deviation;
  cv::meanStdDev(matches, mean, deviation);
  return {deviation[0], deviation[1]};
}

TEST(PhotometricResidual, IsTheDeviationAboveTheMedianOverTheContrast) {
  cv::RNG rng(4);
  for (double principal_offset_px : {0.0, -7.4, 12.5})
    for (const cv::Size size : {cv::Size(1, 1), {2, 9}, {33, 8}, {80, 45}}) {
      const Pair pair(size, rng);
      const cv::Mat1f share = pair.measure(principal_offset_px);
      ASSERT_EQ(share.size(), mapSize(size));
      std::vector<double> sample;
      for (int y = 0; y < size.height; y += 2 * kResidualStep)
        for (int x = 0; x < size.width; x += 2 * kResidualStep)
          if (!matchAt(pair, x, y, principal_offset_px).empty())
            sample.push_back(deviationsNaively(pair, x, y, principal_offset_px)[1]);
      std::sort(sample.begin(), sample.end());
      const double median = sample.empty() ? 0 : sample[sample.size() / 2];
      for (int y = 0; y < share.rows; ++y)
        for (int x = 0; x < share.cols; ++x) {
          const cv::Vec2d deviations =
              deviationsNaively(pair, kResidualStep * x, kResidualStep * y, principal_offset_px);
          ASSERT_NEAR(share(y, x),
                      std::clamp((deviations[1] - median) / (deviations[0] + 1), 0.0, 1.0), 1e-4)
              << size << x << "," << y;
        }
    }
}

TEST(PhotometricResidual, FindsTheWrongMatchAndNotAnotherExposure) {
  cv::RNG rng(6);
  Pair pair({120, 80}, rng);
  pair.disparity_px = 10.0f;
  for (int y = 0; y < pair.right.rows; ++y)
    for (int x = 0; x < pair.right.cols; ++x)
      pair.right(y, x) = cv::saturate_cast<uchar>(pair.left(y, std::min(x + 10, 119)) / 2 + 20);
  pair.left = pair.left / 2;
  pair.disparity_px(cv::Rect(60, 30, 20, 20)) = 4.0f;
  const cv::Mat1f share = pair.measure();
  EXPECT_GT(share(10, 17), 0.5);
  EXPECT_LT(share(4, 8), 0.02);
}

TEST(PhotometricResidual, IsZeroWithoutAnyMatch) {
  cv::RNG rng(8);
  Pair pair({40, 20}, rng);
  pair.disparity_px = kRange.invalid();
  EXPECT_EQ(cv::countNonZero(pair.measure()), 0);
}

}  // namespace
}  // namespace predictive_stereo
