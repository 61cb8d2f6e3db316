#include "odometry/steady_offset.h"

#include <gtest/gtest.h>

#include <random>

namespace predictive_stereo {
namespace {

DisparityOffset offset(double offset_px, double sigma_px) {
  DisparityOffset result;
  result.offset_px = offset_px;
  result.variance_px2 = sigma_px * sigma_px;
  return result;
}

TEST(SteadyOffset, IsKnownAfterAFewCertainFrames) {
  SteadyOffset steady;
  for (int frame = 0; frame < 4; ++frame) {
    steady.update(offset(2, 0.03));
    EXPECT_FALSE(steady.column().known);
    EXPECT_EQ(steady.column().correction_px, 0);
  }
  steady.update(offset(2, 0.03));
  EXPECT_TRUE(steady.column().known);
  EXPECT_DOUBLE_EQ(steady.column().offset_px, 2);
  EXPECT_DOUBLE_EQ(steady.column().sigma_px, 0.03);
  EXPECT_DOUBLE_EQ(steady.column().correction_px, 2);
}

TEST(SteadyOffset, FramesThatTellNothingDoNotCount) {
  SteadyOffset steady;
  for (int frame = 0; frame < 100; ++frame) {
    steady.update(offset(2, 0.5));
    steady.update(offset(2, 0));  // not estimated
  }
  EXPECT_FALSE(steady.column().known);
  EXPECT_EQ(steady.column().correction_px, 0);
}

// As on KITTI: no step for an offset that is small on average.
TEST(SteadyOffset, CamerasThatShakeAreNotCorrected) {
  SteadyOffset steady;
  std::mt19937 random(1);
  std::normal_distribution<double> shake(0.05, 0.2);
  for (int frame = 0; frame < 1000; ++frame) {
    steady.update(offset(shake(random), 0.03));
    ASSERT_EQ(steady.column().correction_px, 0) << frame;
  }
  EXPECT_NEAR(steady.column().offset_px, 0.05, 0.15);
}

TEST(SteadyOffset, FollowsARigThatWasKnockedInOneStep) {
  SteadyOffset steady;
  for (int frame = 0; frame < 50; ++frame) steady.update(offset(0, 0.03));
  int steps = 0;
  double correction_px = 0;
  for (int frame = 0; frame < 100; ++frame) {
    steady.update(offset(0.6, 0.03));
    steps += steady.column().correction_px != correction_px;
    correction_px = steady.column().correction_px;
  }
  EXPECT_GE(steps, 1);
  EXPECT_LE(steps, 2);
  EXPECT_NEAR(correction_px, 0.6, 0.25);
  EXPECT_NEAR(steady.column().offset_px, 0.6, 0.01);
}

}  // namespace
}  // namespace predictive_stereo
