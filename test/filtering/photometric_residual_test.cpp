#include "predictive_stereo/photometric_residual.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace predictive_stereo {
namespace {

const DisparityRange kRange{0, 32};

struct Pair {
  Pair(cv::Size size, cv::RNG& rng) : left(size), right(size), disparity_px(size) {
    rng.fill(left, cv::RNG::UNIFORM, 0, 256);
    rng.fill(right, cv::RNG::UNIFORM, 0, 256);
    rng.fill(disparity_px, cv::RNG::UNIFORM, -6.0f, 20.0f);
    disparity_px.setTo(kRange.invalid(), disparity_px < 0);
  }
  cv::Mat1f measure(double principal_offset_px = 0) const {
    cv::Mat1f excess;
    PhotometricResidual().measure(left, right, disparity_px, kRange, principal_offset_px, excess);
    return excess;
  }
  cv::Mat1b left, right;
  cv::Mat1f disparity_px;
};

/// Left minus right at the match, if there is one.
std::vector<double> differenceAt(const Pair& pair, int x, int y, double principal_offset_px) {
  if (x < 0 || y < 0 || x >= pair.left.cols || y >= pair.left.rows) return {};
  if (!kRange.isValid(pair.disparity_px(y, x))) return {};
  const double match = std::nearbyint(x - pair.disparity_px(y, x) - principal_offset_px);
  if (match < 0 || match >= pair.right.cols) return {};
  return {static_cast<double>(pair.left(y, x)) - pair.right(y, static_cast<int>(match))};
}

/// Standard deviation over the window of 5x5 pixels, in steps of 2 px, around (x, y).
double residualNaively(const Pair& pair, int x, int y, double principal_offset_px) {
  std::vector<double> differences;
  for (int dy = -4; dy <= 4; dy += 2)
    for (int dx = -4; dx <= 4; dx += 2)
      for (double difference : differenceAt(pair, x + dx, y + dy, principal_offset_px))
        differences.push_back(difference);
  if (differences.empty()) return 0;
  const auto count = static_cast<double>(differences.size());
  double mean = 0, variance = 0;
  for (double difference : differences) mean += difference / count;
  for (double difference : differences) variance += std::pow(difference - mean, 2) / count;
  return std::sqrt(variance);
}

TEST(PhotometricResidual, IsTheDeviationOverTheWindowAboveTheMedian) {
  cv::RNG rng(4);
  for (double principal_offset_px : {0.0, -7.4, 12.5})
    for (const cv::Size size : {cv::Size(1, 1), {2, 9}, {33, 8}, {80, 45}}) {
      const Pair pair(size, rng);
      const cv::Mat1f excess = pair.measure(principal_offset_px);
      ASSERT_EQ(excess.size(), cv::Size((size.width + 1) / 2, (size.height + 1) / 2));
      std::vector<double> sample;
      for (int y = 0; y < size.height; y += 8)
        for (int x = 0; x < size.width; x += 8)
          if (!differenceAt(pair, x, y, principal_offset_px).empty())
            sample.push_back(residualNaively(pair, x, y, principal_offset_px));
      std::sort(sample.begin(), sample.end());
      const double median = sample.empty() ? 0 : sample[sample.size() / 2];
      for (int y = 0; y < excess.rows; ++y)
        for (int x = 0; x < excess.cols; ++x)
          ASSERT_NEAR(excess(y, x),
                      residualNaively(pair, 2 * x, 2 * y, principal_offset_px) - median, 1e-3)
              << size << x << "," << y;
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
  const cv::Mat1f excess = pair.measure();
  EXPECT_GT(excess(20, 35), 20);
  EXPECT_LT(excess(8, 20), 1);
}

TEST(PhotometricResidual, IsZeroWithoutAnyMatch) {
  cv::RNG rng(8);
  Pair pair({40, 20}, rng);
  pair.disparity_px = kRange.invalid();
  EXPECT_EQ(cv::countNonZero(pair.measure()), 0);
}

}  // namespace
}  // namespace predictive_stereo
