#include "predictive_stereo/region_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "every_target.h"

namespace predictive_stereo {
namespace {

const DisparityRange kRange;

/// Reference by flood fill from every pixel.
cv::Mat1f naive(const DisparityRange& range, int min_region_px, const cv::Mat1f& disparity_px) {
  cv::Mat1f filtered = disparity_px.clone();
  cv::Mat1b seen = cv::Mat1b::zeros(disparity_px.size());
  const cv::Rect inside(0, 0, disparity_px.cols, disparity_px.rows);
  for (int y = 0; y < disparity_px.rows; ++y)
    for (int x = 0; x < disparity_px.cols; ++x) {
      if (seen(y, x) || !range.isValid(disparity_px(y, x))) continue;
      std::vector<cv::Point> region = {{x, y}};
      seen(y, x) = 1;
      for (size_t i = 0; i < region.size(); ++i)
        for (const cv::Point step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
          const cv::Point from = region[i], to = from + step;
          if (!inside.contains(to) || seen(to) || !range.isValid(disparity_px(to)) ||
              std::abs(disparity_px(to) - disparity_px(from)) > 1.0f)
            continue;
          seen(to) = 1;
          region.push_back(to);
        }
      if (static_cast<int>(region.size()) < min_region_px)
        for (const cv::Point& pixel : region) filtered(pixel) = range.invalid();
    }
  return filtered;
}

/// Patches of random sizes with slopes, noise and holes.
cv::Mat1f patches(cv::Size size, const DisparityRange& range, cv::RNG& rng) {
  cv::Mat1f map(size, range.invalid());
  for (int i = 0; i < size.area() / 60; ++i) {
    const float base = static_cast<float>(range.min_disparity) + rng.uniform(0.0f, 20.0f);
    const float slope = rng.uniform(-0.7f, 0.7f);
    const int x0 = rng.uniform(0, size.width), y0 = rng.uniform(0, size.height);
    for (int y = y0; y < std::min(y0 + rng.uniform(1, 9), size.height); ++y)
      for (int x = x0; x < std::min(x0 + rng.uniform(1, 20), size.width); ++x)
        map(y, x) = rng.uniform(0, 12) == 0 ? range.invalid()
                                            : std::max(base + slope * static_cast<float>(x - x0),
                                                       static_cast<float>(range.min_disparity));
  }
  return map;
}

TEST(RegionFilter, EqualsFloodingOnAllTargets) {
  const DisparityRange below_zero{-16, 64};
  RegionFilter filter;
  for (const DisparityRange& range : {kRange, below_zero})
    for (const cv::Size size : {cv::Size(1, 1), {1, 40}, {40, 1}, {7, 5}, {33, 20}, {131, 77}})
      for (const int least : {0, 1, 2, 7, 40}) {
        cv::RNG rng(size.area() + least);
        const cv::Mat1f map = patches(size, range, rng), expected = naive(range, least, map);
        forEveryTarget([&] {
          cv::Mat1f filtered = map.clone();
          filter.filter(range, least, filtered);
          ASSERT_EQ(cv::countNonZero(filtered != expected), 0) << size << " " << least;
        });
      }
}

TEST(RegionFilter, DropsAnIslandAndKeepsTheSurfaceAroundIt) {
  cv::Mat1f map(40, 60);
  for (int x = 0; x < map.cols; ++x) map.col(x) = 30.0f + 0.5f * static_cast<float>(x);
  const cv::Rect island(20, 10, 9, 11);
  map(island) = 5.0f;
  RegionFilter().filter(kRange, 100, map);
  EXPECT_EQ(cv::countNonZero(map == kRange.invalid()), island.area());
  EXPECT_EQ(cv::countNonZero(map(island) == kRange.invalid()), island.area());
}

TEST(RegionFilter, KeepsARegionOfJustThatSizeAndOneThatWinds) {
  cv::Mat1f map(30, 30, kRange.invalid());
  map(cv::Rect(2, 2, 10, 10)) = 7.0f;
  for (int y = 15; y < 29; y += 2) map(cv::Rect(1, y, 20, 1)) = 9.0f;  // joined at their ends
  for (int y = 16, i = 0; y < 28; y += 2, ++i) map(y, i % 2 ? 1 : 20) = 9.0f;
  const cv::Mat1f before = map.clone();
  RegionFilter filter;
  filter.filter(kRange, 100, map);
  EXPECT_EQ(cv::countNonZero(map != before), 0);
  filter.filter(kRange, 101, map);
  EXPECT_EQ(map(5, 5), kRange.invalid());
  EXPECT_EQ(map(15, 5), 9.0f);
}

}  // namespace
}  // namespace predictive_stereo
