/// Uses exact disparities of planes, for level and for pitched cameras.
#include "detection/road_line.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>

#include "detection/road_rows.h"

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

TEST(RoadRows, CountWhatLiesOnALine) {
  constexpr double kHorizon = 180, kPerRow = 0.3;
  std::vector<double> row, disparity;
  cv::RNG rng(7);
  for (int i = 0; i < 203; ++i) {
    row.push_back(rng.uniform(200, 400));
    disparity.push_back(kPerRow * (row.back() - kHorizon) + rng.uniform(-3.0, 3.0));
  }
  for (int count : {0, 1, 2, 3, 5, 64, 203}) {
    int expected = 0;
    for (size_t i = 0; i < static_cast<size_t>(count); ++i)
      expected +=
          std::abs(disparity[i] - kPerRow * (row[i] - kHorizon)) < 0.3 + 0.03 * disparity[i];
    if (count > 100) {
      EXPECT_GT(expected, 20);
      EXPECT_LT(expected, count - 20);
    }
    for (auto targets = hwy::SupportedTargets(); targets; targets &= targets - 1) {
      hwy::SetSupportedTargetsForTest(targets & ~(targets - 1));
      EXPECT_EQ(countOnLine(row.data(), disparity.data(), count, kHorizon, kPerRow), expected);
    }
    hwy::SetSupportedTargetsForTest(0);
  }
}

}  // namespace
}  // namespace predictive_stereo
