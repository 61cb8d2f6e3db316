/// Seeds of residual groups are identical to a plain reference, on every SIMD target.
#include "detection/residual_group_rows.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <opencv2/core.hpp>

namespace predictive_stereo {
namespace {

const SeedLimits kLimits{-1e6f, 15, 0.7f, 0.8f};

// Residuals in sixteenths of a pixel, whose sums are exact: patches of either sign, noise, holes.
cv::Mat1f residuals(cv::Size size) {
  cv::RNG rng(size.width + 1000 * size.height);
  cv::Mat1f larger(size.height + 2, size.width + 7);
  cv::Mat1f map = larger(cv::Rect(cv::Point(3, 1), size));
  larger = 1e3f;  // outside the map
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u) {
      const int patch = (u / 21 + v / 17) % 3 - 1;
      const int value = 13 * patch + rng.uniform(-8, 9) * (u / 90 + 1) / 2;
      map(v, u) = rng.uniform(0, 5) == 0 ? kLimits.unknown : static_cast<float>(value) / 16;
    }
  return map;
}

// Only inside the map.
cv::Mat1b reference(const cv::Mat1f& map, const cv::Mat1b& pair) {
  cv::Mat1b seeds(map.size(), kNoSeed);
  for (int v = 2; v < map.rows - 2; ++v)
    for (int u = 2; u < map.cols - 2; ++u) {
      if (map(v, u) == kLimits.unknown || std::abs(map(v, u)) < 0.5f * kLimits.least_mean) continue;
      int known = 0, sign = 0;
      float sum = 0;
      for (int y = v - 2; y <= v + 2; ++y)
        for (int x = u - 2; x <= u + 2; ++x) {
          const float r = map(y, x);
          if (r == kLimits.unknown) continue;
          ++known;
          sum += r;
          sign += (r > 0) - (r < 0);
        }
      if (known < kLimits.fewest_known ||
          std::abs(sum) < kLimits.least_mean * static_cast<float>(known) ||
          static_cast<float>(std::abs(sign)) < kLimits.least_sign * static_cast<float>(known))
        continue;
      seeds(v, u) = static_cast<uchar>((sum > 0 ? kPositiveSeed : kNegativeSeed) + 2 * pair(v, u));
    }
  return seeds;
}

TEST(ResidualGroupRows, SeedsAreThoseOfTheReference) {
  for (const cv::Size size :
       {cv::Size(5, 5), cv::Size(12, 9), cv::Size(67, 50), cv::Size(300, 90)}) {
    SCOPED_TRACE(size);
    const cv::Mat1f map = residuals(size);
    cv::Mat1b pair(size);
    cv::RNG(3).fill(pair, cv::RNG::UNIFORM, 0, 4);
    const cv::Mat1b expected = reference(map, pair);
    if (size.width == 300) {
      EXPECT_GT(cv::countNonZero(expected), 1000);
    }
    for (auto targets = hwy::SupportedTargets(); targets; targets &= targets - 1) {
      const auto target = targets & ~(targets - 1);
      hwy::SetSupportedTargetsForTest(target);
      SCOPED_TRACE(hwy::TargetName(target));
      for (int v = kResidualReach; v < size.height - kResidualReach; ++v) {
        const float* rows[kResidualSide];
        for (int k = 0; k < kResidualSide; ++k) rows[k] = map[v + k - kResidualReach];
        std::vector<uint8_t> seeds(static_cast<size_t>(size.width), 77);
        EXPECT_EQ(seedRow(rows, pair[v], size.width, kLimits, seeds.data()),
                  cv::countNonZero(expected.row(v)));
        for (int u = 0; u < size.width; ++u)
          ASSERT_EQ(seeds[static_cast<size_t>(u)], expected(v, u)) << u << ' ' << v;
      }
    }
    hwy::SetSupportedTargetsForTest(0);
  }
}

}  // namespace
}  // namespace predictive_stereo
