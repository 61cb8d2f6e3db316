#include "predictive_stereo/ego_motion.h"

#include <gtest/gtest.h>

#include <opencv2/core/utility.hpp>

#include "odometry/corridor.h"
#include "odometry/ego_motion_state.h"

namespace predictive_stereo {
namespace {

StereoRig smallRig() {
  StereoRig rig;
  rig.size = {640, 240};
  rig.fx_px = rig.fy_px = 400;
  rig.cx_left_px = rig.cx_right_px = 319.5;
  rig.cy_px = 119.5;
  rig.baseline_m = 0.5;
  return rig;
}

struct Pair {
  cv::Mat1b left, right;
};

Pair renderPair(const testing::Corridor& corridor, const StereoRig& rig,
                const Eigen::Isometry3d& T_world_cam, int noise_seed) {
  return {corridor.render(rig, T_world_cam, 0, 1.5, 2 * noise_seed + 1),
          corridor.render(rig, T_world_cam, rig.baseline_m, 1.5, 2 * noise_seed + 2)};
}

Eigen::Isometry3d pose(double x_m, double z_m, double yaw_rad) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << x_m, 0, z_m;
  T.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return T;
}

struct Error {
  double translation_m, rotation_rad;
};

Error errorOf(const EgoMotionEstimate& estimate, const Eigen::Isometry3d& T_world_prev,
              const Eigen::Isometry3d& T_world_cam) {
  const Eigen::Isometry3d delta =
      estimate.motion.T_cam_prev * (T_world_cam.inverse() * T_world_prev).inverse();
  return {delta.translation().norm(), Eigen::AngleAxisd(delta.linear()).angle()};
}

TEST(EgoMotion, DrivesThroughACorridor) {
  const testing::Corridor corridor(1);
  const StereoRig rig = smallRig();
  EgoMotion ego_motion{EgoMotionParams()};
  Eigen::Isometry3d previous;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Isometry3d current = pose(0.1 * std::sin(0.3 * k), 0.6 * k, 0.01 * k);
    const Pair pair = renderPair(corridor, rig, current, k);
    const EgoMotionEstimate estimate = ego_motion.estimate(pair.left, pair.right, rig);
    if (k == 0) {
      EXPECT_EQ(estimate.state, PoseState::kLost);
    } else {
      ASSERT_EQ(estimate.state, PoseState::kKnown);
      const Error error = errorOf(estimate, previous, current);
      EXPECT_LT(error.translation_m, 0.012);
      EXPECT_LT(error.rotation_rad, 0.001);
      EXPECT_GT(estimate.inliers, 60);
    }
    previous = current;
  }
}

// Drives straight on, 0.4 m per frame.
class Losses : public ::testing::Test {
 protected:
  EgoMotionEstimate drive(int frames) { return show(corridor_, frames); }
  // Another place: no view in common with what was seen before.
  EgoMotionEstimate showElsewhere() { return show(elsewhere_, 1); }
  EgoMotionEstimate showBlack(int frames) {
    const cv::Mat1b black(rig_.size, uchar{0});
    EgoMotionEstimate estimate;
    for (int i = 0; i < frames; ++i, ++number_)
      estimate = state_.estimate(black, black, rig_, {}, {}, 0.1);
    return estimate;
  }
  EgoMotionEstimate show(const testing::Corridor& corridor, int frames) {
    EgoMotionEstimate estimate;
    for (int i = 0; i < frames; ++i, ++number_) {
      const Pair pair = renderPair(corridor, rig_, pose(0, 0.4 * number_, 0), number_);
      estimate = state_.estimate(pair.left, pair.right, rig_, {}, {}, 0.1);
    }
    return estimate;
  }
  // The frame before had this sigma of its disparity offset.
  void setOffsetSigma(double sigma_px) { state_.offset.variance_px2 = sigma_px * sigma_px; }

  const testing::Corridor corridor_{1}, elsewhere_{2};
  const StereoRig rig_ = smallRig();
  const EgoMotionParams params_;
  EgoMotionState state_{params_};
  int number_ = 0;
};

TEST_F(Losses, TheNextExpectationIsTheMotionOfOneFrame) {
  drive(3);
  ASSERT_EQ(showBlack(4).state, PoseState::kHeld);
  ASSERT_EQ(drive(1).frames, 5);
  EXPECT_NEAR(state_.usual.T_cam_prev.translation().z(), -0.4, 0.01);
  ASSERT_EQ(drive(1).frames, 1);
  EXPECT_NEAR(state_.usual.T_cam_prev.translation().z(), -0.4, 0.01);
}

// The cameras shake against each other: what was measured in the frame before says less about it.
TEST_F(Losses, TheDisparityOffsetOfALostFrameHasTheJitter) {
  const double drift_px = params_.disparity_offset_drift_px,
               jitter_px = params_.disparity_jitter_px;
  const double variance_px2 = 0.05 * 0.05 + drift_px * drift_px + jitter_px * jitter_px;
  drive(3);
  setOffsetSigma(0.05);
  const EgoMotionEstimate lost = showElsewhere();
  ASSERT_EQ(lost.state, PoseState::kHeld);
  EXPECT_NEAR(lost.disparity_offset_sigma_px, std::sqrt(variance_px2), 1e-9);
  ASSERT_EQ(state_.references.size(), 2);
  EXPECT_GE(state_.references.back().offset.variance_px2, variance_px2);
}

TEST_F(Losses, TheDisparityOffsetDriftsInEveryLostFrame) {
  const double drift_px = params_.disparity_offset_drift_px,
               jitter_px = params_.disparity_jitter_px;
  drive(3);
  setOffsetSigma(0.05);
  const double before_px2 = state_.references.front().offset.variance_px2;
  const EgoMotionEstimate lost = showBlack(9);
  ASSERT_EQ(lost.state, PoseState::kHeld);
  const double drifted_px2 = 9 * drift_px * drift_px;
  EXPECT_NEAR(lost.disparity_offset_sigma_px,
              std::sqrt(0.05 * 0.05 + drifted_px2 + jitter_px * jitter_px), 1e-9);
  EXPECT_NEAR(state_.references.front().offset.variance_px2, before_px2 + drifted_px2, 1e-9);
}

TEST_F(Losses, TheDisparityOffsetIsNeverLessCertainThanAtTheStart) {
  const double sigma_px = params_.disparity_offset_sigma_px;
  const EgoMotionEstimate lost = showBlack(100);
  EXPECT_NEAR(lost.disparity_offset_sigma_px, std::hypot(sigma_px, params_.disparity_jitter_px),
              1e-9);
}

// The left camera hangs for longer than the last good pair is kept, while both move to the side.
// The caller masks these pairs: they would give the next one wrong depths.
TEST(EgoMotion, AMaskedPairIsNoReference) {
  const testing::Corridor corridor(1);
  const StereoRig rig = smallRig();
  const cv::Mat1b all(rig.size, uint8_t{255});
  EgoMotion ego_motion{EgoMotionParams()};
  Pair hung;
  for (int k = 0; k < 16; ++k) {
    const Eigen::Isometry3d current = pose(0.02 * k, 0, 0);
    Pair pair = renderPair(corridor, rig, current, k);
    const bool hangs = k > 1 && k < 14;
    if (hangs) pair.left = hung.left;
    const EgoMotionEstimate estimate =
        ego_motion.estimate(pair.left, pair.right, rig, hangs ? all : cv::Mat1b());
    if (!hangs) hung = pair;
    const bool is_known = k == 1 || k == 15;
    EXPECT_EQ(estimate.state == PoseState::kKnown, is_known) << k;
    if (is_known) {
      EXPECT_LT(errorOf(estimate, pose(0.02 * (k - 1), 0, 0), current).translation_m, 0.01) << k;
    }
  }
}

TEST(EgoMotion, RefusesImagesOfAnotherSize) {
  EgoMotion ego_motion{EgoMotionParams()};
  const StereoRig rig = smallRig();
  const cv::Mat1b right_size(rig.size, uchar{0}), other(100, 100, uchar{0});
  EXPECT_THROW(ego_motion.estimate(other, right_size, rig), std::invalid_argument);
  EXPECT_THROW(ego_motion.estimate(right_size, other, rig), std::invalid_argument);
  EXPECT_THROW(ego_motion.estimate(right_size, right_size, rig, other), std::invalid_argument);
}

TEST(EgoMotion, RefusesParametersOutOfRange) {
  EgoMotionParams params;
  params.features = 3;
  EXPECT_THROW(EgoMotion{params}, std::invalid_argument);
}

TEST(EgoMotion, SameForAnyNumberOfThreads) {
  const testing::Corridor corridor(2);
  const StereoRig rig = smallRig();
  std::vector<Pair> pairs;
  for (int k = 0; k < 4; ++k)
    pairs.push_back(renderPair(corridor, rig, pose(0, 0.5 * k, 0.02 * k), k));
  std::vector<Eigen::Matrix4d> expected;
  for (int threads : {1, 2, 3, 7}) {
    cv::setNumThreads(threads);
    EgoMotion ego_motion{EgoMotionParams()};
    for (size_t k = 0; k < pairs.size(); ++k) {
      const auto estimate = ego_motion.estimate(pairs[k].left, pairs[k].right, rig);
      if (threads == 1) expected.push_back(estimate.motion.T_cam_prev.matrix());
      EXPECT_EQ(estimate.motion.T_cam_prev.matrix(), expected[k]) << threads << " threads";
    }
  }
  cv::setNumThreads(-1);
}

}  // namespace
}  // namespace predictive_stereo
