/// Groups of residuals of one sign.
#include "detection/along_channel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "detection/long_residual.h"

namespace predictive_stereo {
namespace {

constexpr float kLeastMean_px = 0.7f;

/// A map of residuals on a surface of one disparity, 0 but for what a test adds.
struct Scene {
  explicit Scene(cv::Size cells)
      : residual_px(cells, 0.0f), pair(cells, uchar{0}), cells_px(cells, 20.0f) {}
  std::vector<std::vector<cv::Point>> groups() const {
    return groupResiduals(residual_px, pair, cells_px, kLeastMean_px);
  }

  cv::Mat1f residual_px;
  cv::Mat1b pair;
  cv::Mat1f cells_px;
};

TEST(ResidualGroups, HaveOneSign) {
  Scene scene({80, 40});
  scene.residual_px(cv::Rect(5, 5, 9, 9)) = 1;
  scene.residual_px(cv::Rect(30, 5, 20, 15)) = -1;
  const auto groups = scene.groups();
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(cv::boundingRect(groups[0]), cv::Rect(6, 6, 7, 7));
  EXPECT_EQ(groups[0].size(), 49u);
  EXPECT_EQ(cv::boundingRect(groups[1]), cv::Rect(31, 6, 18, 13));
  EXPECT_EQ(groups[1].size(), 18u * 13);
}

TEST(ResidualGroups, EndAtStepsOfTheDisparityAndOfThePair) {
  for (const bool at_disparity : {true, false}) {
    Scene scene({80, 40});
    scene.residual_px(cv::Rect(10, 10, 40, 15)) = 1;
    if (at_disparity)
      scene.cells_px(cv::Rect(30, 0, 50, 40)) = 22;
    else
      scene.pair(cv::Rect(30, 0, 50, 40)) = 1;
    const auto groups = scene.groups();
    ASSERT_EQ(groups.size(), 2u);
    for (const auto& group : groups)
      for (const cv::Point p : group) EXPECT_EQ(p.x < 30, group.front().x < 30) << at_disparity;
  }
}

TEST(ResidualGroups, NeedEnoughKnownCells) {
  Scene scene({80, 40});
  scene.residual_px.setTo(kUnknownResidual);
  scene.residual_px(cv::Rect(10, 10, 3, 2)) = 0.8f;
  ASSERT_EQ(scene.groups().size(), 1u);
  EXPECT_EQ(scene.groups()[0].size(), 2u) << "in the middle";
  scene.residual_px(cv::Rect(10, 10, 1, 1)) = kUnknownResidual;
  EXPECT_TRUE(scene.groups().empty());
  scene.residual_px = kUnknownResidual;
  EXPECT_TRUE(scene.groups().empty());
}

// Cell by cell; residuals are in sixteenths, so that sums are exact.
bool isSeed(const cv::Mat1f& map, cv::Point at) {
  int known = 0, sign = 0;
  float sum = 0;
  for (int y = std::max(at.y - 1, 0); y <= std::min(at.y + 1, map.rows - 1); ++y)
    for (int x = std::max(at.x - 1, 0); x <= std::min(at.x + 1, map.cols - 1); ++x) {
      const float r = map(y, x);
      if (r == kUnknownResidual) continue;
      ++known;
      sum += r;
      sign += (r > 0) - (r < 0);
    }
  return map(at) != kUnknownResidual && std::abs(map(at)) >= 0.5f * kLeastMean_px && known >= 6 &&
         std::abs(sum) >= kLeastMean_px * static_cast<float>(known) &&
         static_cast<float>(std::abs(sign)) >= 0.6f * static_cast<float>(known);
}

TEST(ResidualGroups, AreThoseOfAReference) {
  for (const cv::Size size :
       {cv::Size(1, 1), cv::Size(5, 5), cv::Size(67, 50), cv::Size(300, 90)}) {
    SCOPED_TRACE(size);
    Scene scene(size);
    cv::RNG rng(size.width);
    cv::Mat1b seeds[2] = {cv::Mat1b::zeros(size), cv::Mat1b::zeros(size)};  // of either sign
    for (int v = 0; v < size.height; ++v)
      for (int u = 0; u < size.width; ++u) {
        const int value = 13 * ((u / 21 + v / 17) % 3 - 1) + rng.uniform(-8, 9) * (u / 90 + 1) / 2;
        scene.residual_px(v, u) =
            rng.uniform(0, 5) == 0 ? kUnknownResidual : static_cast<float>(value) / 16;
      }
    std::map<int, int> expected;  // number of groups by size
    for (int v = 0; v < size.height; ++v)
      for (int u = 0; u < size.width; ++u)
        if (isSeed(scene.residual_px, {u, v})) seeds[scene.residual_px(v, u) > 0](v, u) = 255;
    for (const cv::Mat1b& of_sign : seeds) {
      cv::Mat1i labels, stats;
      cv::Mat1d centroids;
      const int count = cv::connectedComponentsWithStats(of_sign, labels, stats, centroids, 4);
      for (int k = 1; k < count; ++k) ++expected[stats(k, cv::CC_STAT_AREA)];
    }
    if (size.width == 300) {
      EXPECT_GT(expected.size(), 10u);
    }
    std::map<int, int> found;
    for (const auto& group : scene.groups()) ++found[static_cast<int>(group.size())];
    EXPECT_EQ(found, expected);
  }
}

// One obstacle of 3x9 cells.
struct ShiftedObstacles : testing::Test {
  ShiftedObstacles() : scene({40, 30}) {
    obstacles.number = cv::Mat1i(30, 40, -1);
    obstacles.number(kCells).setTo(0);
    obstacles.sizes = {kCells.area()};
    scene.residual_px.setTo(kUnknownResidual);
  }
  // Of a part of the obstacle.
  void setResidual(const cv::Rect& cells, float residual_px) {
    scene.residual_px(cells) = residual_px;
  }
  std::vector<std::vector<cv::Point>> groups() const {
    return shiftedObstacles(obstacles, scene.residual_px, kLeastMean_px);
  }

  const cv::Rect kCells{10, 8, 3, 9};
  Scene scene;
  Obstacles obstacles;
};

TEST_F(ShiftedObstacles, AreWhole) {
  setResidual(kCells, -1.02f * kLeastMean_px);
  ASSERT_EQ(groups().size(), 1u);
  EXPECT_EQ(groups()[0].size(), 27u);
  EXPECT_EQ(cv::boundingRect(groups()[0]), kCells);
  setResidual(kCells, -0.98f * kLeastMean_px);
  EXPECT_TRUE(groups().empty());
}

TEST_F(ShiftedObstacles, HaveOneSign) {
  setResidual(kCells, 2);
  setResidual({10, 8, 3, 1}, -0.1f);
  EXPECT_EQ(groups().size(), 1u);
  setResidual({10, 8, 3, 2}, -0.1f);
  EXPECT_TRUE(groups().empty()) << "2 of 9 rows: less than 80 %";
}

TEST_F(ShiftedObstacles, HaveEnoughCells) {
  setResidual({10, 8, 3, 2}, 1);
  EXPECT_EQ(groups().size(), 1u);
  setResidual({10, 8, 1, 1}, kUnknownResidual);
  EXPECT_TRUE(groups().empty());
}

TEST_F(ShiftedObstacles, AreInTheirOrder) {
  const cv::Rect larger(20, 8, 5, 9);
  obstacles.number(larger).setTo(1);
  obstacles.sizes.push_back(larger.area());
  setResidual(kCells, 1);
  setResidual(larger, -1);
  ASSERT_EQ(groups().size(), 2u);
  EXPECT_EQ(groups()[0].size(), 27u);
  EXPECT_EQ(groups()[1].size(), 45u);
}

}  // namespace
}  // namespace predictive_stereo
