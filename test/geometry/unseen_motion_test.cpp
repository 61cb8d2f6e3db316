#include "predictive_stereo/unseen_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

Velocity driving(double speed_mps, double turn_rate_radps) {
  Velocity velocity;
  velocity.twist << 0, 0, speed_mps, 0, turn_rate_radps, 0;
  return velocity;
}

double sigmaAhead(const CameraMotion& motion) { return std::sqrt(motion.covariance(2, 2)); }

TEST(UnseenMotion, TheLastVelocityGoesOn) {
  const Velocity curve = driving(10, 0.2);
  const CameraMotion motion = unseenMotion(curve, 0.9);
  EXPECT_TRUE(motion.T_cam_prev.inverse().isApprox(motionOf(curve.twist, 0.9), 1e-9));
}

TEST(UnseenMotion, NoTimeNoMotion) {
  const CameraMotion motion = unseenMotion(driving(10, 0.2), 0);
  EXPECT_TRUE(motion.T_cam_prev.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_TRUE(motion.covariance.isZero());
}

// Straight ahead, turns do not change the way ahead.
TEST(UnseenMotion, GrowsAsTheIntegralOfTheIntegralOfNoise) {
  const UnseenMotionModel model;
  for (const double t_s : {0.1, 1.0, 4.0}) {
    const CameraMotion motion = unseenMotion(driving(10, 0), t_s);
    EXPECT_NEAR(sigmaAhead(motion), model.acceleration_noise * std::sqrt(t_s * t_s * t_s / 3),
                1e-6 * t_s);
    EXPECT_NEAR(std::sqrt(motion.covariance(4, 4)),
                model.turn_acceleration_noise * std::sqrt(t_s * t_s * t_s / 3), 1e-6 * t_s);
  }
}

// Many cars whose speed and turn rate change as the model says.
TEST(UnseenMotion, TheCovarianceIsThatOfTheErrors) {
  const UnseenMotionModel model;
  const Velocity begin = driving(10, 0.1);
  constexpr double kSpan_s = 0.5, kStep_s = 0.01;
  const CameraMotion expected = unseenMotion(begin, kSpan_s);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  constexpr int kCars = 2000;
  double sum = 0;
  for (int car = 0; car < kCars; ++car) {
    Vector6d twist = begin.twist;
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    for (double t_s = 0; t_s < kSpan_s - kStep_s / 2; t_s += kStep_s) {
      T = compose(T, motionOf(twist, kStep_s));
      for (int i = 0; i < 6; ++i)
        twist(i) += std::sqrt(kStep_s) * normal(random) *
                    (i < 3 ? model.acceleration_noise : model.turn_acceleration_noise);
    }
    const Eigen::Isometry3d off = compose(T.inverse(), expected.T_cam_prev.inverse());
    const Vector6d error = constantTwist(off, 1);
    sum += error.dot(expected.covariance.ldlt().solve(error)) / 6;
  }
  EXPECT_NEAR(sum / kCars, 1, 0.1);
}

TEST(UnseenMotion, WhatWasNeverMeasuredIsMoreUncertain) {
  EXPECT_GT(sigmaAhead(unseenMotion(Velocity::unknown(), 0.5)),
            3 * sigmaAhead(unseenMotion(driving(10, 0), 0.5)));
  CameraMotion measured;
  measured.T_cam_prev.translation() = Eigen::Vector3d(0, 0, -1);
  measured.covariance = 1e-4 * Matrix6d::Identity();
  const Velocity velocity = Velocity::after(measured, 0.1);
  EXPECT_NEAR(velocity.twist(2), 10, 0.05);
  EXPECT_GE(velocity.covariance(2, 2), 0.01);
}

TEST(UnseenMotion, AMotionBetweenStampsThatNearlyCoincideTellsNoVelocity) {
  CameraMotion measured;
  measured.T_cam_prev.translation() = Eigen::Vector3d(0, 0, -0.01);
  measured.covariance = 1e-4 * Matrix6d::Identity();
  const Velocity velocity = Velocity::after(measured, 1e-9);
  EXPECT_LT(velocity.twist.norm(), 1e-3);
  EXPECT_TRUE(velocity.covariance.isApprox(Velocity::unknown().covariance, 1e-6));
}

// Later, the velocity itself is a part of the uncertainty, as a car may have stopped or not.
TEST(UnseenMotion, AnOldVelocityPredictsNothing) {
  const UnseenMotionModel model;
  const Velocity fast = driving(20, 0), curve = driving(0, 2);
  const auto after = [&](const Velocity& velocity, double t_s) {
    return constantTwist(unseenMotion(velocity, t_s).T_cam_prev.inverse(), 1);
  };
  const double more_s = 3;
  EXPECT_NEAR(after(fast, model.moving_s + more_s)(2), 20 * model.moving_s, 1e-6);
  EXPECT_GT(3 * sigmaAhead(unseenMotion(fast, model.moving_s + more_s)), 20 * more_s);
  EXPECT_NEAR(after(curve, model.turning_s + more_s)(4), 2 * model.turning_s, 1e-6);
  EXPECT_GT(
      unseenMotion(curve, 4).covariance(4, 4) - unseenMotion(driving(0, 0), 4).covariance(4, 4),
      0.9 * std::pow(2 * (4 - model.turning_s), 2));
}

TEST(UnseenMotion, AfterAMinuteNothingIsKnown) {
  const CameraMotion minute = unseenMotion(driving(1, 0.1), 60);
  EXPECT_GT(minute.covariance.diagonal().head<3>().minCoeff(), 9999);
  for (const double t_s : {61.0, 4e9, 1e18})
    EXPECT_EQ(unseenMotion(driving(1, 0.1), t_s).covariance, minute.covariance) << t_s;
  EXPECT_TRUE(minute.covariance.allFinite());
}

}  // namespace
}  // namespace predictive_stereo
