/// Uses exact disparities of a level road with objects on it.
#include "detection/level_ground.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "every_target.h"

namespace predictive_stereo {
namespace {

constexpr double kCameraHeight_m = 1.5;

StereoRig testRig() {
  StereoRig rig;
  rig.size = {600, 400};
  rig.fx_px = rig.fy_px = 600;
  rig.cx_left_px = rig.cx_right_px = 300;
  rig.cy_px = 200;
  rig.baseline_m = 0.5;
  return rig;
}

// A road below the sky.
cv::Mat1f road(const StereoRig& rig, double height_m = kCameraHeight_m) {
  cv::Mat1f disparity(rig.size, 0.5f);
  for (int y = 0; y < disparity.rows; ++y)
    disparity.row(y).setTo(std::max(0.5, (y - rig.cy_px) * rig.baseline_m / height_m));
  return disparity;
}

// A vertical board at a depth, from column x on, with its lower edge on the road.
cv::Rect putBoard(const StereoRig& rig, double depth_m, double width_m, double height_m, int x,
                  cv::Mat1f& disparity) {
  const double pixels_per_m = rig.fx_px / depth_m;
  const int foot = cvRound(rig.cy_px + kCameraHeight_m * pixels_per_m);
  const cv::Rect board(x, foot - cvRound(height_m * pixels_per_m), cvRound(width_m * pixels_per_m),
                       cvRound(height_m * pixels_per_m));
  disparity(board).setTo(rig.disparityTimesDepth() / depth_m);
  return board;
}

cv::Mat1b groundOf(const cv::Mat1f& disparity, const StereoRig& rig) {
  LevelGround level;
  level.setFrame(rig, DisparityRange(), disparity);
  const cv::Rect lattice(0, 0, rig.size.width / 2, rig.size.height / 2);
  return ~level.layerIn(lattice, disparity, -10, 1000);
}

double shareOf(const cv::Mat1b& ground, const cv::Rect& pixels) {
  const cv::Rect lattice(pixels.x / 2, pixels.y / 2, pixels.width / 2, pixels.height / 2);
  return double(cv::countNonZero(ground(lattice))) / lattice.area();
}

TEST(LevelGround, IsTheRoadAndNothingOnIt) {
  const StereoRig rig = testRig();
  for (double depth_m : {8.0, 15.0, 30.0}) {
    SCOPED_TRACE(depth_m);
    cv::Mat1f disparity = road(rig);
    const cv::Rect board = putBoard(rig, depth_m, 1.8, 1.5, 250, disparity);
    cv::RNG noise(1);
    cv::Mat1f error(disparity.size());
    noise.fill(error, cv::RNG::NORMAL, 0, 0.05);
    disparity += error;
    const cv::Mat1b ground = groundOf(disparity, rig);
    EXPECT_LT(shareOf(ground, board), 0.15);
    const cv::Rect shadow(board.x - 40, board.br().y - 6, 36, 12);
    EXPECT_GT(shareOf(ground, shadow), 0.9);
    EXPECT_EQ(cv::countNonZero(ground.rowRange(0, 100)), 0) << "above the horizon";
  }
}

TEST(LevelGround, KnowsNoHeightOfTheCamera) {
  const StereoRig rig = testRig();
  for (double height_m : {0.4, 1.5, 2.5})
    EXPECT_GT(shareOf(groundOf(road(rig, height_m), rig), {0, 240, 600, 140}), 0.95) << height_m;
}

TEST(LevelGround, IsNoBonnet) {
  const StereoRig rig = testRig();
  cv::Mat1f disparity = road(rig);
  const cv::Rect front = putBoard(rig, 6, 1.8, 0.7, 250, disparity);
  // 0.8 m below the camera, from 6 to 7.2 m.
  const cv::Rect bonnet(front.x, cvRound(rig.cy_px + 0.8 * 600 / 7.2), front.width,
                        front.y - cvRound(rig.cy_px + 0.8 * 600 / 7.2));
  for (int y = bonnet.y; y < bonnet.br().y; ++y)
    disparity(cv::Rect(bonnet.x, y, bonnet.width, 1)).setTo((y - rig.cy_px) * 0.5 / 0.8);
  ASSERT_GT(bonnet.height, 10);
  const cv::Mat1b ground = groundOf(disparity, rig);
  EXPECT_EQ(shareOf(ground, bonnet), 0);
  EXPECT_LT(shareOf(ground, front), 0.2);
}

TEST(LevelGround, IsNotSeenOnAWall) {
  const StereoRig rig = testRig();
  EXPECT_EQ(cv::countNonZero(groundOf(cv::Mat1f(rig.size, 20.0f), rig)), 0);
  EXPECT_EQ(cv::countNonZero(groundOf(cv::Mat1f(rig.size, -1.0f), rig)), 0) << "nothing known";
}

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
  const int reach = std::min(std::max(static_cast<int>(0.15f * d), 1), 4);
  if (y < 2 * reach || y + 2 * reach >= map.rows) return 0;
  const float above = map(y - 2 * reach, x), beneath = map(y + 2 * reach, x);
  const float expected = 4 * static_cast<float>(reach) * d / horizon;
  if (above < 0 || beneath < 0 || beneath - above < 0.5f * expected ||
      beneath - above > 2 * expected)
    return 0;
  return horizon * 0.5f / d;
}

TEST(LevelGround, IsThatOfTheReference) {
  for (const cv::Size size :
       {cv::Size(1, 30), cv::Size(2, 3), cv::Size(31, 64), cv::Size(66, 90), cv::Size(301, 101)}) {
    SCOPED_TRACE(size);
    const cv::Mat1f map = disparities(size);
    StereoRig rig = testRig();
    rig.cy_px = 0;
    int level = 0;
    forEveryTarget([&] {
      level = 0;
      LevelGround ground;
      ground.setFrame(rig, DisparityRange(), map);
      for (int v = 2; v < (size.height + 1) / 2; ++v)
        for (int u = 0; u < (size.width + 1) / 2; ++u) {
          ASSERT_EQ(ground.below_m(v)[u], reference(map, v, u, static_cast<float>(2 * v)))
              << u << ' ' << v;
          level += ground.isLevel({u, v});
        }
    });
    if (size.width == 301) {
      EXPECT_GT(level, 1500);
      EXPECT_LT(level, 7000);
    }
  }
}

TEST(LevelGround, LayerIsWithinItsDisparitiesAndNoGround) {
  StereoRig rig = testRig();
  rig.cy_px = 20;
  for (const int width : {2, 14, 33, 66, 500}) {
    const cv::Mat1f map = disparities({width, 120});
    const cv::Rect area(width / 8, 5, (width + 1) / 2 - width / 8, 50);
    forEveryTarget([&] {
      LevelGround ground;
      ground.setFrame(rig, DisparityRange(), map);
      const cv::Mat1b above = ground.layerIn(area, map, -10, 1000),
                      layer = ground.layerIn(area, map, 10, 20);
      for (int v = 0; v < area.height; ++v)
        for (int u = 0; u < area.width; ++u) {
          const float d = map(2 * (area.y + v), 2 * (area.x + u));
          EXPECT_EQ(layer(v, u), d >= 10 && d <= 20 ? above(v, u) : 0) << u << ' ' << v;
        }
      if (width == 500) {
        EXPECT_GT(cv::countNonZero(above == 0), 1000) << "ground";
      }
    });
  }
}

}  // namespace
}  // namespace predictive_stereo
