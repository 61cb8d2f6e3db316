/// The covariances against derivatives of the motion itself.
#include "detection/motion_noise.h"

#include <gtest/gtest.h>

#include <limits>

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

Eigen::Isometry3d someMotion() {
  return Eigen::Translation3d(0.2, -0.1, 1.4) *
         Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.2, 1, 0.1).normalized());
}

// Correlated, with variances of different sizes.
Matrix6d someCovariance() {
  Matrix6d L = Matrix6d::Zero();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) L(i, j) = 0.002 * (i + 1) * (i == j ? 2 : 0.7 - 0.3 * j);
  return L * L.transpose();
}

// Derivative of the past position by the motion's error in the current frame.
Eigen::Matrix<double, 3, 6> derivative(const Eigen::Isometry3d& T_past_cam,
                                       const Eigen::Vector3d& point_m) {
  constexpr double kStep = 1e-6;
  Eigen::Matrix<double, 3, 6> J;
  for (int i = 0; i < 6; ++i) {
    const Vector6d step = kStep * Vector6d::Unit(i);
    J.col(i) =
        (T_past_cam * (motionOf(step, 1) * point_m) - T_past_cam * (motionOf(-step, 1) * point_m)) /
        (2 * kStep);
  }
  return J;
}

TEST(MotionNoise, IsTheCovarianceOfThePastPoint) {
  const Matrix6d covariance = someCovariance();
  const Eigen::Vector3d point_m(-2, 1, 9);
  const auto J = derivative(someMotion(), point_m);
  const Eigen::Matrix3d expected = J * covariance * J.transpose();
  EXPECT_LT((pointCovariance(someMotion(), covariance, point_m) - expected).norm(),
            1e-6 * expected.norm());
}

TEST(MotionNoise, OfManyDepthsIsThatOfEachPoint) {
  const PastDepthNoise noise(someMotion(), someCovariance());
  for (const double depth_m : {0.8, 6.0, 40.0})
    for (const double x : {-0.8, 0.0, 0.5})
      for (const double y : {-0.3, 0.4}) {
        const double expected = pointCovariance(someMotion(), someCovariance(),
                                                depth_m * Eigen::Vector3d(x, y, 1))(2, 2);
        const auto got = noise.along(static_cast<float>(y))
                             .variance(static_cast<float>(x), static_cast<float>(depth_m));
        EXPECT_NEAR(got, expected, 1e-4 * expected) << depth_m << " m, " << x << ", " << y;
      }
}

TEST(MotionNoise, WhatIsNoCovarianceIsNotTold) {
  EXPECT_EQ(toldCovariance(someCovariance()), someCovariance());
  EXPECT_EQ(toldCovariance(unseenCovariance()), unseenCovariance());
  Matrix6d none = someCovariance(), lopsided = someCovariance(), negative = someCovariance();
  none(3, 3) = std::numeric_limits<double>::quiet_NaN();
  lopsided(0, 5) = 1;
  negative(4, 4) = -1e-6;
  for (const Matrix6d& bad : {Matrix6d(Matrix6d::Zero()), none, lopsided, negative}) {
    const Matrix6d taken = toldCovariance(bad);
    EXPECT_DOUBLE_EQ(taken(1, 1), kUntoldMotionSigma_m * kUntoldMotionSigma_m);
    EXPECT_DOUBLE_EQ(taken(4, 4), kUntoldMotionSigma_rad * kUntoldMotionSigma_rad);
    EXPECT_TRUE(taken.isDiagonal());
  }
}

}  // namespace
}  // namespace predictive_stereo
