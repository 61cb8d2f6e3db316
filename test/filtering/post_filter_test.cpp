#include "predictive_stereo/post_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "every_target.h"

namespace predictive_stereo {
namespace {

constexpr int kSlopeReach = 8;  // pixels beside a hole, over which the slope is measured

DisparityRange rangeFrom(int min_disparity) {
  DisparityRange range;
  range.min_disparity = min_disparity;
  return range;
}

// Layers of slowly changing disparity with noise and a share of invalid pixels; exact multiples of
// the range's first disparity and differences of exactly 1 px occur.
cv::Mat1f makeMap(cv::Size size, const DisparityRange& range, double invalid_share, int seed) {
  cv::RNG rng(seed);
  cv::Mat1f map(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const int layer = (x / 23 + y / 11) % 3;
      const double value = 10.0 * layer + 0.02 * x + rng.uniform(0, 5) * 0.5;
      map(y, x) = rng.uniform(0.0, 1.0) < invalid_share
                      ? range.invalid()
                      : static_cast<float>(range.min_disparity + (layer ? value : cvFloor(value)));
    }
  return map;
}

cv::Mat1f supportNaively(const DisparityRange& range, int min_support, const cv::Mat1f& map) {
  cv::Mat1f filtered = map.clone();
  for (int y = 0; y < map.rows; ++y)
    for (int x = 0; x < map.cols; ++x) {
      int support = 0;
      for (int v = std::max(0, y - 2); v <= std::min(map.rows - 1, y + 2); ++v)
        for (int u = std::max(0, x - 2); u <= std::min(map.cols - 1, x + 2); ++u)
          support +=
              range.isValid(map(v, u)) && map(v, u) >= map(y, x) - 1 && map(v, u) <= map(y, x) + 1;
      if (!range.isValid(map(y, x)) || support < min_support) filtered(y, x) = range.invalid();
    }
  return filtered;
}

cv::Mat1f medianNaively(const DisparityRange& range, size_t fewest, const cv::Mat1f& map) {
  cv::Mat1f filtered(map.size(), range.invalid());
  for (int y = 0; y < map.rows; ++y)
    for (int x = 0; x < map.cols; ++x) {
      std::vector<float> values;
      for (int v = std::max(0, y - 1); v <= std::min(map.rows - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(map.cols - 1, x + 1); ++u)
          if (range.isValid(map(v, u))) values.push_back(map(v, u));
      std::sort(values.begin(), values.end());
      if (range.isValid(map(y, x)) || values.size() >= fewest)
        filtered(y, x) = values[(values.size() - 1) / 2];
    }
  return filtered;
}

cv::Mat1f certainNaively(const DisparityRange& range, const cv::Mat1f& measured,
                         const cv::Mat1b& ambiguity, int most, const cv::Mat1f& map) {
  cv::Mat1f certain = map.clone();
  for (int y = 0; y < map.rows; ++y)
    for (int x = 0; x < map.cols; ++x)
      if (range.isValid(measured(y, x)) && ambiguity(y, x) > most) certain(y, x) = range.invalid();
  return certain;
}

// The disparity rises evenly over a hole from `before` to `after`, if these belong to one surface;
// `outer` are the pixels beyond them, for the slopes.
std::optional<double> riseOver(int steps, float before, float after,
                               std::optional<std::pair<float, float>> outer, float tolerance_px) {
  const float rise = after - before;
  bool one_surface = std::abs(rise) <= tolerance_px;
  if (outer) {
    const float slope = ((before - outer->first) + (outer->second - after)) / (2 * kSlopeReach);
    one_surface |= std::abs(rise - slope * static_cast<float>(steps)) <= tolerance_px;
  }
  return one_surface ? std::optional(rise / steps) : std::nullopt;
}

// Along the rows of the map, from left to right.
void fillNaively(const DisparityRange& range, int max_length, float tolerance_px, bool occlusions,
                 cv::Mat1f& map) {
  for (int y = 0; y < map.rows; ++y)
    for (int x = 1; x < map.cols; ++x) {
      const auto isValid = [&](int i) {
        return i >= 0 && i < map.cols && range.isValid(map(y, i));
      };
      if (!isValid(x) || isValid(x - 1)) continue;
      int before = x - 1;
      while (before >= 0 && !isValid(before)) --before;
      const int steps = x - before;
      if (before < 0 || steps - 1 > max_length) continue;
      std::optional<std::pair<float, float>> outer;
      if (isValid(before - kSlopeReach) && isValid(x + kSlopeReach))
        outer = {map(y, before - kSlopeReach), map(y, x + kSlopeReach)};
      const float near = map(y, x) - map(y, before);
      auto rise = riseOver(steps, map(y, before), map(y, x), outer, tolerance_px);
      int width = 0;  // of the surface behind the hole
      while (x + width < map.cols && map(y, x + width) >= map(y, before) + tolerance_px) ++width;
      const bool hidden = near > tolerance_px && static_cast<float>(steps - 1) <= near + 4 &&
                          width >= static_cast<int>(near / 2);
      if (!rise && occlusions && hidden) rise = 0;
      if (!rise) continue;
      for (int i = 1; i < steps; ++i)
        map(y, before + i) = static_cast<float>(map(y, before) + *rise * i);
    }
}

cv::Mat1f filledNaively(const DisparityRange& range, int max_length, const cv::Mat1f& map) {
  cv::Mat1f filled = map.clone();
  fillNaively(range, max_length, 3, true, filled);
  filled = filled.t();
  fillNaively(range, max_length, 3, false, filled);
  return filled.t();
}

void expectEqual(const cv::Mat1f& filtered, const cv::Mat1f& expected, const char* what,
                 double tolerance = 0) {
  ASSERT_EQ(filtered.size(), expected.size());
  EXPECT_LE(cv::norm(filtered, expected, cv::NORM_INF), tolerance)
      << what << " " << filtered.size();
}

const std::vector<cv::Size> kSizes = {{1, 1},   {2, 1},   {7, 1},   {1, 9},  {5, 5},    {8, 3},
                                      {9, 40},  {12, 12}, {13, 2},  {20, 3}, {33, 17},  {64, 48},
                                      {127, 5}, {300, 4}, {66, 99}, {3, 64}, {1242, 37}};

// Differences of exactly 1 px across 0, where floats change their sign, and to -0 and the floats
// next to it.
TEST(PostFilter, CountsSupportAcrossZero) {
  const float tiny = std::numeric_limits<float>::denorm_min();
  const std::vector<float> values = {-1.0f, -0.5f, -0.0f, 0.0f, tiny,
                                     -tiny, 0.5f,  1.0f,  1.5f, -2.0f};
  const DisparityRange range = rangeFrom(-1);
  cv::Mat1f map(40, 50);
  cv::RNG rng(3);
  for (float& value : map) value = values[rng.uniform(0, static_cast<int>(values.size()))];
  forEveryTarget([&] {
    for (int min_support : {1, 8, 16, 25}) {
      cv::Mat1f filtered;
      filterBySupport(range, min_support, map, filtered);
      expectEqual(filtered, supportNaively(range, min_support, map), "support");
    }
  });
}

TEST(PostFilter, EqualNaiveReferences) {
  for (int min_disparity : {0, -16, 16})
    for (double invalid_share : {0.0, 0.1, 0.6, 1.0})
      for (cv::Size size : kSizes) {
        const DisparityRange range = rangeFrom(min_disparity);
        const cv::Mat1f map = makeMap(size, range, invalid_share, size.width);
        cv::Mat1f filtered;
        for (int min_support : {0, 1, 10, 25}) {
          const cv::Mat1f expected = supportNaively(range, min_support, map);
          forEveryTarget([&] {
            filterBySupport(range, min_support, map, filtered);
            expectEqual(filtered, expected, "support");
          });
        }
        for (const int fewest : {3, 5})
          forEveryTarget([&] {
            median3x3(range, fewest, map, filtered);
            expectEqual(filtered, medianNaively(range, fewest, map), "median");
          });
        const cv::Mat1f measured = makeMap(size, range, invalid_share, size.width + 1);
        cv::Mat1b ambiguity(size);
        cv::RNG(size.width).fill(ambiguity, cv::RNG::UNIFORM, 0, 256);
        ambiguity(0, 0) = 255;
        for (int most : {0, 128, 254, 255})
          forEveryTarget([&] {
            leaveOutAmbiguous(range, measured, ambiguity, (most + 0.5) / 255, map, filtered);
            expectEqual(filtered, certainNaively(range, measured, ambiguity, most, map), "certain");
          });
        for (int max_width : {0, 2, 40}) {
          const cv::Mat1f expected = filledNaively(range, max_width, map);
          forEveryTarget([&] {
            fillHoles(range, max_width, 3, map, filtered);
            expectEqual(filtered, expected, "holes", 1e-4);
          });
        }
      }
}

// A road whose disparity rises by 0.5 px a row, with a hole that is 20 rows high and as wide as the
// image: its sides are 10 px apart.
TEST(PostFilter, SurfacesThatSlopeAreContinuedOverHoles) {
  const DisparityRange range = rangeFrom(0);
  cv::Mat1f road(80, 50), filled;
  for (int y = 0; y < road.rows; ++y) road.row(y) = 10 + 0.5f * static_cast<float>(y);
  cv::Mat1f map = road.clone();
  map.rowRange(30, 50) = range.invalid();
  fillHoles(range, 40, 3, map, filled);
  expectEqual(filled, road, "road", 1e-4);
  fillHoles(range, 19, 3, map, filled);
  expectEqual(filled, map, "a longer hole");
  map.rowRange(50, 80) += 20;  // a vehicle stands on it
  fillHoles(range, 40, 3, map, filled);
  expectEqual(filled, map, "two surfaces");
}

// A wall, and a pole of disparity 40 before it: the hole to its left is an occlusion only if the
// pole is wide enough.
TEST(PostFilter, ThinThingsHideNothing) {
  const DisparityRange range = rangeFrom(0);
  for (int width : {14, 15}) {
    cv::Mat1f wall(1, 100, 10.f), filled;
    wall.colRange(40, 60) = range.invalid();
    wall.colRange(60, 60 + width) = 40;
    fillHoles(range, 40, 3, wall, filled);
    EXPECT_EQ(filled(0, 50), width == 15 ? 10 : range.invalid());
  }
}

TEST(PostFilter, InvalidNeighboursGiveNoSupport) {
  // The invalid value is exactly 1 px below the smallest disparity.
  const DisparityRange range = rangeFrom(0);
  cv::Mat1f map(40, 40, range.invalid()), filtered;
  map(20, 20) = 0;
  filterBySupport(range, 2, map, filtered);
  EXPECT_EQ(filtered(20, 20), range.invalid());
}

TEST(PostFilter, ViewsAreReadAndWrittenInPlace) {
  const DisparityRange range;
  const cv::Mat1f large = makeMap({90, 70}, range, 0.2, 3);
  const cv::Rect rect(11, 7, 53, 41);
  const cv::Mat1f view = large(rect), copy = view.clone();
  cv::Mat1f frame(80, 100, 77.f);
  cv::Mat1f target = frame(cv::Rect(20, 10, 53, 41));
  filterBySupport(range, 10, view, target);
  expectEqual(frame(cv::Rect(20, 10, 53, 41)), supportNaively(range, 10, copy), "support");
  fillHoles(range, 5, 3, view, target);
  expectEqual(frame(cv::Rect(20, 10, 53, 41)), filledNaively(range, 5, copy), "holes", 1e-4);
  median3x3(range, 3, view, target);
  expectEqual(frame(cv::Rect(20, 10, 53, 41)), medianNaively(range, 3, copy), "median");
  // The memory around the view is unchanged.
  frame(cv::Rect(20, 10, 53, 41)) = 77.f;
  EXPECT_EQ(cv::countNonZero(frame != 77.f), 0);
}

TEST(PostFilter, ReuseMemoryAndRefuseToWorkInPlace) {
  const DisparityRange range;
  cv::Mat1f map = makeMap({50, 40}, range, 0.2, 3), filtered(40, 50);
  const uchar* memory = filtered.data;
  filterBySupport(range, 10, map, filtered);
  fillHoles(range, 10, 3, map, filtered);
  median3x3(range, 3, map, filtered);
  EXPECT_EQ(filtered.data, memory);
  EXPECT_THROW(filterBySupport(range, 10, map, map), std::invalid_argument);
  EXPECT_THROW(fillHoles(range, 10, 3, map, map), std::invalid_argument);
  EXPECT_THROW(median3x3(range, 3, map, map), std::invalid_argument);
  const cv::Mat1b ambiguity(map.size(), uchar{255});
  EXPECT_THROW(leaveOutAmbiguous(range, map, ambiguity, 1, map, map), std::invalid_argument);
  leaveOutAmbiguous(range, map, ambiguity, 1, map, filtered);
  expectEqual(filtered, map, "all are certain enough");
  cv::Mat1f empty, nothing;
  filterBySupport(range, 10, empty, nothing);
  fillHoles(range, 10, 3, empty, nothing);
  median3x3(range, 3, empty, nothing);
  EXPECT_TRUE(nothing.empty());
}

TEST(PostFilter, SameForEveryNumberOfThreads) {
  const DisparityRange range;
  const cv::Mat1f map = makeMap({333, 101}, range, 0.2, 3);
  const int before = cv::getNumThreads();
  for (int threads : {1, 2, 3, 7}) {
    cv::setNumThreads(threads);
    cv::Mat1f filtered;
    filterBySupport(range, 10, map, filtered);
    expectEqual(filtered, supportNaively(range, 10, map), "support");
    fillHoles(range, 20, 3, map, filtered);
    expectEqual(filtered, filledNaively(range, 20, map), "holes", 1e-4);
    median3x3(range, 3, map, filtered);
    expectEqual(filtered, medianNaively(range, 3, map), "median");
  }
  cv::setNumThreads(before);
}

}  // namespace
}  // namespace predictive_stereo
