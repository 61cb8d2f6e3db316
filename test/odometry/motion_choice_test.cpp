#include "odometry/motion_choice.h"

#include <gtest/gtest.h>

#include <limits>

namespace predictive_stereo {
namespace {

// Two points, of trust 1 and 0.5, of which those given are inliers.
PoseSolution solution(char first, char second, double sigma) {
  PoseSolution solution;
  solution.found = true;
  solution.inlier = {first, second};
  solution.covariance = sigma * sigma * Matrix6d::Identity();
  return solution;
}

std::vector<Correspondence> twoPoints() {
  std::vector<Correspondence> points(2);
  points[1].trust = 0.5;
  return points;
}

StereoRig rig() {
  StereoRig rig;
  rig.size = {640, 480};
  rig.fx_px = rig.fy_px = 500;
  rig.cx_left_px = rig.cx_right_px = 320;
  rig.cy_px = 240;
  rig.baseline_m = 0.2;
  return rig;
}

TEST(MotionWorth, IsTheTrustOfTheInliersOverTheirMeanSigma) {
  EXPECT_NEAR(motionWorth(solution(1, 1, 0.01), twoPoints()), 1.5 / 0.01, 1e-6);
  EXPECT_NEAR(motionWorth(solution(0, 1, 0.01), twoPoints()), 0.5 / 0.01, 1e-6);
  EXPECT_EQ(motionWorth(solution(0, 0, 0.01), twoPoints()), 0);
  PoseSolution uneven = solution(1, 1, 1);
  uneven.covariance(0, 0) = 1e-12;  // the sixth root of 1e-6 is 0.1
  EXPECT_NEAR(motionWorth(uneven, twoPoints()), 1.5 / 0.1, 1e-6);
}

// Rounding can make a covariance that is nearly singular indefinite. A solution with it must not
// win or lose by chance against NaN.
TEST(MotionWorth, IsNothingWithoutACovarianceThatIsPositive) {
  EXPECT_EQ(motionWorth(solution(1, 1, 0), twoPoints()), 0);
  PoseSolution indefinite = solution(1, 1, 1);
  indefinite.covariance(5, 5) = -1e-9;
  EXPECT_EQ(motionWorth(indefinite, twoPoints()), 0);
  indefinite.covariance(5, 5) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(motionWorth(indefinite, twoPoints()), 0);
}

// The camera moves ahead by 1 m. A feature at 100 px from the centre with d = 10 px is at 10 m, and
// moves by 11 px.
TEST(PredictSamePositions, ComparesWhereMostFeaturesGo) {
  ReferenceFrame reference;
  for (int i = 0; i < 20; ++i) {
    Feature feature;
    feature.position = {220, 240};
    feature.disparity_px = 10;
    reference.features.push_back(feature);
  }
  const Eigen::Isometry3d still = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d ahead = still;
  ahead.translation().z() = -1;
  EXPECT_TRUE(predictSamePositions(rig(), reference, ahead, ahead));
  EXPECT_FALSE(predictSamePositions(rig(), reference, ahead, still));
  ahead.translation().z() = -0.1;  // 1.01 px
  EXPECT_TRUE(predictSamePositions(rig(), reference, ahead, still));

  // One of twenty features that moves far does not decide, three do.
  ahead.translation().z() = -0.1;
  reference.features[0].disparity_px = 100;  // at 1 m: 11 px
  EXPECT_TRUE(predictSamePositions(rig(), reference, ahead, still));
  reference.features[1].disparity_px = reference.features[2].disparity_px = 100;
  EXPECT_FALSE(predictSamePositions(rig(), reference, ahead, still));
}

TEST(HighQuantile, IsTheNinthTenth) {
  std::vector<double> values = {9, 1, 8, 2, 7, 3, 6, 4, 5, 0};
  EXPECT_EQ(highQuantile(values), 9);
  values = {3};
  EXPECT_EQ(highQuantile(values), 3);
}

}  // namespace
}  // namespace predictive_stereo
