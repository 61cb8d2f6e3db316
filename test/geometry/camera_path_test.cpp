#include "predictive_stereo/camera_path.h"

#include <gtest/gtest.h>

#include <cmath>

namespace predictive_stereo {
namespace {

constexpr double kSpeed_mps = 10;

/// A car that drives straight on along z, ten frames per second.
class Straight : public testing::Test {
 protected:
  Straight() { see(); }

  void skip(int frames) { number_ += frames; }
  /// The next frame, tracked against the one that is `frames` back.
  void see(int frames = 1) {
    EgoMotionEstimate estimate;
    estimate.state = PoseState::kKnown;
    estimate.frames = frames;
    estimate.motion.T_cam_prev.translation().z() = -0.1 * kSpeed_mps * frames;
    estimate.motion.covariance = 1e-6 * Matrix6d::Identity();
    add(estimate);
  }
  /// Not tracked.
  void miss(int frames = 1, PoseState state = PoseState::kHeld) {
    for (int i = 0; i < frames; ++i) {
      EgoMotionEstimate estimate;
      estimate.state = state;
      add(estimate);
    }
  }
  void add(const EgoMotionEstimate& estimate) {
    path_.add(estimate, ++number_ * std::chrono::milliseconds(100));
  }

  double z_m() const { return path_.pose().T_odom_cam.translation().z(); }
  double sigma_m() const { return std::sqrt(path_.pose().covariance(2, 2)); }
  PoseState state() const { return path_.pose().state; }

  CameraPath path_;
  int number_ = -1;
};

TEST_F(Straight, TheFirstFrameIsTheOrigin) {
  EXPECT_EQ(state(), PoseState::kKnown);
  EXPECT_FALSE(path_.motionStart());
  EXPECT_FALSE(path_.pose().velocity);
  EXPECT_TRUE(path_.pose().covariance.isZero());
}

// Of the motion since the previous frame with a known pose.
TEST_F(Straight, SaysWhetherAPartOfTheLastMotionWasNotSeen) {
  see();
  EXPECT_EQ(path_.pose().motion_covariance, 1e-6 * Matrix6d::Identity());
  miss(2);
  EXPECT_EQ(path_.pose().motion_covariance, unseenCovariance());
  see(3);  // from the last known frame
  EXPECT_EQ(path_.pose().motion_covariance, 1e-6 * Matrix6d::Identity());
  miss(2);
  see(1);  // from a lost frame
  EXPECT_EQ(path_.pose().motion_covariance, unseenCovariance());
  see();
  EXPECT_EQ(path_.pose().motion_covariance, 1e-6 * Matrix6d::Identity());
}

TEST_F(Straight, ALostFrameGoesOnWithTheLastVelocity) {
  see();
  miss();
  EXPECT_EQ(state(), PoseState::kHeld);
  EXPECT_NEAR(z_m(), 2, 0.01);
  EXPECT_FALSE(path_.pose().velocity);
  EXPECT_FALSE(path_.motionStart());
  const double after_one_m = sigma_m();
  EXPECT_GT(after_one_m, 0.01);
  miss();
  EXPECT_NEAR(z_m(), 3, 0.01);
  EXPECT_GT(sigma_m(), 1.5 * after_one_m);
}

TEST_F(Straight, AMotionFromBeforeTheLossLeavesNothingUnseen) {
  see();
  miss(2);
  see(3);
  EXPECT_EQ(state(), PoseState::kKnown);
  EXPECT_EQ(path_.motionStart(), Stamp(std::chrono::milliseconds(100)));
  EXPECT_NEAR(z_m(), 4, 1e-9);
  EXPECT_LT(sigma_m(), 0.003);
  ASSERT_TRUE(path_.pose().velocity);
  EXPECT_NEAR(path_.pose().velocity->twist(2), kSpeed_mps, 1e-9);
}

TEST_F(Straight, WhatWasNotSeenStaysInThePath) {
  see();
  miss(5);
  const double lost_m = sigma_m();
  see();
  EXPECT_EQ(state(), PoseState::kKnown);
  EXPECT_GE(sigma_m(), lost_m);
  for (int i = 0; i < 50; ++i) see();
  EXPECT_GE(sigma_m(), lost_m);
  miss(5);
  EXPECT_GT(sigma_m(), 1.3 * lost_m) << "the next loss adds to it";
}

TEST_F(Straight, AGapIsALoss) {
  see();
  path_.breakOff();
  skip(19);
  miss(1, PoseState::kLost);
  EXPECT_EQ(state(), PoseState::kLost);
  EXPECT_NEAR(z_m(), 21, 0.1);
  const double gap_m = sigma_m();
  EXPECT_GT(gap_m, 0.5);
  see();
  EXPECT_EQ(state(), PoseState::kKnown);
  EXPECT_GE(sigma_m(), gap_m);
}

TEST_F(Straight, NoMotionLeadsAcrossAGap) {
  see();
  path_.breakOff();
  skip(19);
  see();
  EXPECT_EQ(state(), PoseState::kLost) << "its start is forgotten";
  EXPECT_FALSE(path_.motionStart());
}

TEST_F(Straight, WithoutAVelocityNothingIsExpected) {
  miss();
  EXPECT_EQ(z_m(), 0);
  EXPECT_GT(3 * sigma_m(), 0.1 * kSpeed_mps);
}

// More than a minute in the dark.
TEST_F(Straight, MotionsStartAtTheLastFramesOnly) {
  see();
  miss(700, PoseState::kLost);
  see(EgoMotionEstimate::kMostFrames + 1);
  EXPECT_EQ(state(), PoseState::kLost);
  miss(3);
  see(4);
  EXPECT_EQ(state(), PoseState::kKnown);
  EXPECT_GT(path_.pose().covariance.diagonal().head<3>().minCoeff(), 9999);
}

// The camera looks to the right of a robot, 2 m ahead of its centre.
TEST(CameraPath, TheBodyHasItsOwnPose) {
  Eigen::Isometry3d T_body_cam = Eigen::Isometry3d::Identity();
  T_body_cam.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  T_body_cam.translation().x() = 2;
  CameraPath path;
  path.setOrigin(Eigen::Isometry3d::Identity());
  EgoMotionEstimate estimate;
  path.add(estimate, Stamp(0), T_body_cam);
  EXPECT_TRUE(path.pose().T_odom_body.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_TRUE(path.pose().T_odom_cam.isApprox(T_body_cam));
  estimate.state = PoseState::kKnown;
  estimate.motion.T_cam_prev.translation().x() = -1;  // the camera's right is the robot's front
  estimate.motion.covariance(0, 0) = 0.04;
  estimate.motion.covariance(4, 4) = 0.01;
  path.add(estimate, std::chrono::seconds(1), T_body_cam);
  const PoseEstimate& pose = path.pose();
  EXPECT_TRUE(pose.T_odom_body.translation().isApprox(Eigen::Vector3d(1, 0, 0)));
  ASSERT_TRUE(pose.velocity);
  EXPECT_NEAR(pose.velocity->twist(0), 1, 1e-9);
  EXPECT_NEAR(pose.covariance(0, 0), 0.04, 1e-9);
  EXPECT_NEAR(pose.covariance(5, 5), 0.01, 1e-9);
  EXPECT_NEAR(pose.covariance(1, 1), 0.04, 1e-9) << "2 m times 0.1 rad";
}

}  // namespace
}  // namespace predictive_stereo
