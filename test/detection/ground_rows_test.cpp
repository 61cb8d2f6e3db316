/// The kernel of level ground is identical to a plain reference, on every SIMD target.
#include "detection/ground_rows.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "every_target.h"

namespace predictive_stereo {
namespace {

const GroundLimits kLimits{0, 0.15f, 0, 0.5f, 0.5f, 2};

// A road with noise and holes; part of a larger map.
cv::Mat1f disparities(cv::Size size) {
  cv::RNG rng(size.width);
  cv::Mat1f larger(size.height, size.width + 5);
  for (int y = 0; y < larger.rows; ++y)
    for (int x = 0; x < larger.cols; ++x)
      larger(y, x) =
          rng.uniform(0, 12) == 0 ? -1.0f : 0.4f * static_cast<float>(y) + rng.uniform(-1.5f, 1.5f);
  return larger(cv::Rect(cv::Point(2, 0), size));
}

float reference(const cv::Mat1f& map, int v, int u, float horizon) {
  const int y = 2 * v, x = 2 * u;
  const float d = map(y, x);
  if (d < 0 || !(d > 0)) return 0;
  const int reach = std::min(std::max(static_cast<int>(0.15f * d), 1), kMostGroundReach);
  if (y < 2 * reach || y + 2 * reach >= map.rows) return 0;
  const float above = map(y - 2 * reach, x), beneath = map(y + 2 * reach, x);
  const float expected = 4 * static_cast<float>(reach) * d / horizon;
  if (above < 0 || beneath < 0 || beneath - above < 0.5f * expected ||
      beneath - above > 2 * expected)
    return 0;
  return horizon * 0.5f / d;
}

TEST(GroundRows, AreThoseOfTheReference) {
  for (const cv::Size size :
       {cv::Size(1, 30), cv::Size(2, 3), cv::Size(31, 64), cv::Size(66, 90), cv::Size(301, 101)}) {
    SCOPED_TRACE(size);
    const cv::Mat1f map = disparities(size);
    const int width = (size.width + 1) / 2, height = (size.height + 1) / 2;
    int level = 0;
    forEveryTarget([&] {
      level = 0;
      for (int v = 1; v < height; ++v) {
        GroundLimits limits = kLimits;
        limits.horizon_distance_px = static_cast<float>(2 * v);
        const float *above[kMostGroundReach], *beneath[kMostGroundReach];
        for (int k = 0; k < kMostGroundReach; ++k) {
          const int upper = 2 * (v - k - 1), lower = 2 * (v + k + 1);
          above[k] = upper >= 0 ? map[upper] : nullptr;
          beneath[k] = lower < map.rows ? map[lower] : nullptr;
        }
        std::vector<float> below(static_cast<size_t>(width));
        levelRow(map[2 * v], above, beneath, width, limits, below.data());
        for (int u = 0; u < width; ++u) {
          ASSERT_EQ(below[static_cast<size_t>(u)], reference(map, v, u, limits.horizon_distance_px))
              << u << ' ' << v;
          level += below[static_cast<size_t>(u)] > 0;
        }
      }
    });
    if (size.width == 301) {
      EXPECT_GT(level, 1500);
      EXPECT_LT(level, 7000);
    }
  }
}

}  // namespace
}  // namespace predictive_stereo
