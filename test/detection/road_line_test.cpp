/// Uses exact disparities of planes, for level and for pitched cameras.
#include "detection/road_line.h"

#include <gtest/gtest.h>

#include <cmath>

#include "every_target.h"

namespace predictive_stereo {
namespace {

StereoRig testRig() {
  StereoRig rig;
  rig.size = {600, 400};
  rig.fx_px = rig.fy_px = 600;
  rig.cx_left_px = rig.cx_right_px = 300;
  rig.cy_px = 200;
  rig.baseline_m = 0.5;
  return rig;
}

// A road `height_m` below a camera with downward pitch `pitch_rad`: n . p = height in its frame.
cv::Mat1f roadOf(const StereoRig& rig, double height_m, double pitch_rad, double noise_px) {
  cv::Mat1f disparity(rig.size, -1.0f);
  for (int y = 0; y < disparity.rows; ++y) {
    const double per_depth =
        std::cos(pitch_rad) * (y - rig.cy_px) / rig.fy_px + std::sin(pitch_rad);
    const double d = rig.disparityTimesDepth() * per_depth / height_m;
    if (d > 0.5) disparity.row(y).setTo(d);
  }
  cv::Mat1f error(disparity.size());
  cv::RNG(3).fill(error, cv::RNG::NORMAL, 0, noise_px);
  disparity += error;
  return disparity;
}

TEST(RoadLine, GivesHeightsAboveTheRoad) {
  const StereoRig rig = testRig();
  for (double pitch_rad : {0.0, 0.1, -0.05})
    for (double height_m : {0.6, 1.6}) {
      SCOPED_TRACE(testing::Message() << pitch_rad << " rad, " << height_m << " m");
      cv::Mat1f disparity = roadOf(rig, height_m, pitch_rad, 0.1);
      // Walls and vehicles occlude much of it.
      disparity.colRange(0, 250) = cv::max(disparity.colRange(0, 250), 20.0f);
      disparity.colRange(250, 330) = cv::max(disparity.colRange(250, 330), 35.0f);
      const auto line = fitRoadLine(rig, DisparityRange(), disparity);
      ASSERT_TRUE(line);
      // Points at 12 m, on the road and 2 m above it.
      for (double above_m : {0.0, 2.0}) {
        const double down_m = (height_m - above_m - 12 * std::sin(pitch_rad)) / std::cos(pitch_rad);
        const double row = rig.cy_px + rig.fy_px * down_m / 12;
        EXPECT_NEAR(line->heightOf(row, rig.disparityTimesDepth() / 12, rig.baseline_m), above_m,
                    0.12);
      }
    }
}

TEST(RoadLine, IsNoWall) {
  const StereoRig rig = testRig();
  EXPECT_FALSE(fitRoadLine(rig, DisparityRange(), cv::Mat1f(rig.size, 20.0f)));
  EXPECT_FALSE(fitRoadLine(rig, DisparityRange(), cv::Mat1f(rig.size, -1.0f)));
  // A ceiling: disparity grows upwards.
  cv::Mat1f ceiling(rig.size);
  for (int y = 0; y < ceiling.rows; ++y) ceiling.row(y).setTo(0.3 * (420 - y));
  EXPECT_FALSE(fitRoadLine(rig, DisparityRange(), ceiling));
}

TEST(RoadLine, IsTheSameOnEveryTarget) {
  const StereoRig rig = testRig();
  cv::Mat1f disparity = roadOf(rig, 1.2, 0.05, 0.3);
  disparity.colRange(100, 330) = cv::max(disparity.colRange(100, 330), 20.0f);
  const auto expected = fitRoadLine(rig, DisparityRange(), disparity);
  ASSERT_TRUE(expected);
  forEveryTarget([&] {
    const auto line = fitRoadLine(rig, DisparityRange(), disparity);
    ASSERT_TRUE(line);
    EXPECT_EQ(line->horizon_row_px, expected->horizon_row_px);
    EXPECT_EQ(line->disparity_per_row, expected->disparity_per_row);
  });
}

}  // namespace
}  // namespace predictive_stereo
