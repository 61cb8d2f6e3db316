/// Past frames are the same as in a plain list, or, of a fast camera, a part of it.
#include "detection/frame_history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr double kPeriod_s = 0.1;

// Each frame has a different position, orientation, grey values and disparities.
DetectionInput frameOf(int k) {
  DetectionInput input;
  input.stamp_s = 5 + kPeriod_s * k;
  input.rig.size = {40, 24};
  input.left = cv::Mat1b(input.rig.size, static_cast<uchar>(10 + k));
  input.measured_disparity_px = cv::Mat1f(input.rig.size, static_cast<float>(k) + 0.25f);
  input.pose_state = PoseState::kKnown;
  input.T_odom_cam = Eigen::Translation3d(0.1 * k, 0.02 * k, 1.5 * k) *
                     Eigen::AngleAxisd(0.03 * k, Eigen::Vector3d(0.1, 1, 0.2).normalized());
  return input;
}

void expectPast(const std::vector<PastFrame>& past, int current, const std::vector<int>& expected) {
  ASSERT_EQ(past.size(), expected.size());
  for (size_t i = 0; i < past.size(); ++i) {
    SCOPED_TRACE(expected[i]);
    const DetectionInput then = frameOf(expected[i]), now = frameOf(current);
    EXPECT_EQ(past[i].frame->pyramid.level(0)(12, 20), 10 + expected[i]);
    EXPECT_EQ(past[i].frame->pyramid.level(1).size(), cv::Size(20, 12));
    EXPECT_EQ(past[i].frame->disparity_px(23, 39), static_cast<float>(expected[i]) + 0.25f);
    EXPECT_NEAR(past[i].seconds, kPeriod_s * (current - expected[i]), 1e-9);
    // A point of the current camera is the same world point in the past camera.
    const Eigen::Vector3d point(1, -2, 12);
    EXPECT_LT((then.T_odom_cam * (past[i].T_past_cam * point) - now.T_odom_cam * point).norm(),
              1e-9);
  }
}

TEST(FrameHistory, KeepsTheLastEight) {
  FrameHistory history;
  std::vector<int> expected;
  for (int k = 0; k < 20; ++k) {
    SCOPED_TRACE(k);
    history.remember(frameOf(k));
    EXPECT_EQ(history.current().disparity_px(0, 0), static_cast<float>(k) + 0.25f);
    expectPast(history.past(), k, expected);
    expected.insert(expected.begin(), k);
    if (expected.size() > FrameHistory::kFarthest) expected.pop_back();
  }
  EXPECT_EQ(expected.size(), 8u);
}

TEST(FrameHistory, KeepsTimeNotFrames) {
  constexpr double kFast_s = 1.0 / 30;
  FrameHistory history;
  for (int k = 0; k < 60; ++k) {
    SCOPED_TRACE(k);
    DetectionInput input = frameOf(k);
    input.stamp_s = 5 + kFast_s * k;
    history.remember(input);
    const std::vector<PastFrame> past = history.past();
    if (k == 0) continue;
    EXPECT_NEAR(past[0].seconds, kFast_s, 1e-9) << "the previous frame";
    for (size_t i = 0; i < past.size(); ++i) {
      const int kept = past[i].frame->pyramid.level(0)(0, 0) - 10;
      EXPECT_NEAR(past[i].seconds, kFast_s * (k - kept), 1e-9);
      EXPECT_TRUE(
          past[i].T_past_cam.isApprox(relative(frameOf(kept).T_odom_cam, input.T_odom_cam)));
      if (i < 2) continue;
      EXPECT_NEAR(past[i].seconds - past[i - 1].seconds, 3 * kFast_s, 1e-9);
    }
    EXPECT_GE(past.back().seconds, std::min(0.6, kFast_s * k) - 1e-9);
  }
}

TEST(FrameHistory, OfAFastCameraEndsWhereThePoseDoesNotGoOn) {
  FrameHistory history;
  for (int k = 0; k < 12; ++k) {
    DetectionInput input = frameOf(k);
    input.stamp_s = 5 + 0.02 * k;
    history.remember(input);
    history.setFollows(k != 7);
    const std::vector<PastFrame> past = history.past();
    if (k < 8) continue;
    EXPECT_EQ(past.back().frame->pyramid.level(0)(0, 0), 10 + 7);
  }
}

TEST(FrameHistory, AddsTheMotionsUp) {
  FrameHistory history;
  PathCovariance last, second_last;
  for (int k = 0; k < 6; ++k) {
    DetectionInput input = frameOf(k);
    input.motion_covariance = (1 + k) * 1e-4 * Matrix6d::Identity();
    history.remember(input);
    const CameraMotion motion{relative(input.T_odom_cam, frameOf(k - 1).T_odom_cam),
                              input.motion_covariance};
    if (k < 4) continue;
    (k == 4 ? second_last : last).add(motion, CommonErrors::Zero());
    if (k == 5) second_last.add(motion, CommonErrors::Zero());
  }
  const std::vector<PastFrame> past = history.past();
  EXPECT_TRUE(past[0].motion_covariance.isApprox(last.covariance()));
  EXPECT_TRUE(past[1].motion_covariance.isApprox(second_last.covariance()));
  EXPECT_GT(past[1].motion_covariance(0, 0), 1.1e-3) << "5 and 6 times 1e-4, and the turn's part";
}

TEST(FrameHistory, CopiesWhatItKeeps) {
  FrameHistory history;
  DetectionInput input = frameOf(0);
  history.remember(input);
  input.left.setTo(0);
  input.measured_disparity_px.setTo(0);
  history.remember(frameOf(1));
  expectPast(history.past(), 1, {0});
}

TEST(FrameHistory, AddsAStepToKnownDisparities) {
  FrameHistory history;
  DetectionInput input = frameOf(0);
  const DisparityRange range;
  input.measured_disparity_px.setTo(range.invalid());
  input.measured_disparity_px(1, 2) = 7;
  history.remember(input);
  history.addToDisparities(range, 1.5);
  history.remember(frameOf(1));
  const cv::Mat1f& disparity_px = history.past().at(0).frame->disparity_px;
  EXPECT_EQ(disparity_px(1, 2), 8.5f);
  EXPECT_EQ(disparity_px(0, 0), range.invalid());
}

TEST(FrameHistory, EndsWhereAPoseIsUnknown) {
  FrameHistory history;
  for (int k = 0; k < 3; ++k) history.remember(frameOf(k));
  DetectionInput lost = frameOf(3);
  lost.pose_state = PoseState::kLost;
  history.remember(lost);
  EXPECT_TRUE(history.past().empty());
  history.remember(frameOf(4));
  EXPECT_TRUE(history.past().empty());
  history.remember(frameOf(5));
  expectPast(history.past(), 5, {4});
}

TEST(FrameHistory, EndsWhereThePoseDoesNotGoOn) {
  FrameHistory history;
  for (int k = 0; k < 4; ++k) {
    history.remember(frameOf(k));
    history.setFollows(k != 2);
  }
  // The pose of 2 does not continue that of 1, but 3 continues 2.
  expectPast(history.past(), 3, {2});
  history.remember(frameOf(4));
  history.setFollows(false);
  EXPECT_TRUE(history.past().empty());
}

// The frames without pose may not have come here.
TEST(FrameHistory, EndsWhereNobodySawTheMotion) {
  FrameHistory history;
  for (int k = 0; k < 3; ++k) history.remember(frameOf(k));
  DetectionInput found_again = frameOf(3);
  found_again.motion_covariance = unseenCovariance();
  history.remember(found_again);
  EXPECT_TRUE(history.past().empty());
  history.remember(frameOf(4));
  expectPast(history.past(), 4, {3});
}

TEST(FrameHistory, EndsWhereTimeDoesNotGoOn) {
  for (const double step_s : {0.0, -0.3}) {
    FrameHistory history;
    history.remember(frameOf(0));
    history.remember(frameOf(1));
    DetectionInput back = frameOf(2);
    back.stamp_s = frameOf(1).stamp_s + step_s;
    history.remember(back);
    EXPECT_TRUE(history.past().empty());
  }
}

TEST(FrameHistory, KnowsAnImageThatIsShownAgain) {
  FrameHistory frames;
  DetectionInput again = frameOf(0);
  again.stamp_s += kPeriod_s;
  EXPECT_FALSE(frames.isShownAgain(again)) << "there is no past";
  frames.remember(frameOf(0));
  EXPECT_TRUE(frames.isShownAgain(again));
  again.T_odom_cam = frameOf(1).T_odom_cam;  // poses come from another sensor
  EXPECT_TRUE(frames.isShownAgain(again));

  DetectionInput other = again;
  other.left = again.left.clone();
  ++other.left(23, 39);
  EXPECT_FALSE(frames.isShownAgain(other)) << "one pixel differs";
  other = again;
  other.pose_state = PoseState::kLost;
  EXPECT_FALSE(frames.isShownAgain(other));
  other = again;
  other.motion_covariance = unseenCovariance();
  EXPECT_FALSE(frames.isShownAgain(other));
  for (const double seconds : {-kPeriod_s, 0.0, 1.5}) {
    other = again;
    other.stamp_s = frameOf(0).stamp_s + seconds;
    EXPECT_FALSE(frames.isShownAgain(other)) << seconds;
  }
}

TEST(FrameHistory, ForgetsOnReset) {
  FrameHistory history;
  for (int k = 0; k < 12; ++k) history.remember(frameOf(k));
  history.reset();
  history.remember(frameOf(12));
  EXPECT_TRUE(history.past().empty());
}

std::vector<bool> agreesWithMotion(PoseCheck& check, const std::vector<double>& contradicting) {
  std::vector<bool> result;
  for (double share : contradicting) result.push_back(check.agreesWithMotion(share));
  return result;
}

TEST(PoseCheck, BelievesWhatChangesSlowly) {
  PoseCheck check;
  // Each share differs by less than a fifth of the image from the previous one, up to most of it.
  EXPECT_EQ(agreesWithMotion(check, {0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.79}),
            std::vector<bool>(7, true));
}

TEST(PoseCheck, DoubtsWhatJumps) {
  PoseCheck check;
  EXPECT_EQ(agreesWithMotion(check, {0.1, 0.4, 0.1, 0.29}),
            (std::vector<bool>{true, false, true, true}));
}

TEST(PoseCheck, BelievesInTheThirdFrameInARow) {
  PoseCheck check;
  EXPECT_EQ(agreesWithMotion(check, {0.1, 0.5, 0.5, 0.5, 0.5}),
            (std::vector<bool>{true, false, false, true, true}));
  // Two contradictions, one agreement, two contradictions: the count starts again.
  EXPECT_EQ(agreesWithMotion(check, {0.8, 0.8, 0.5, 0.8, 0.8}),
            (std::vector<bool>{false, false, true, false, false}));
}

TEST(PoseCheck, DoubtsWhatCoversNearlyAll) {
  PoseCheck check;
  EXPECT_FALSE(check.agreesWithMotion(0.85)) << "of the first frame nothing is usual yet";
  PoseCheck half;
  EXPECT_TRUE(half.agreesWithMotion(0.75)) << "half of a view may move";
  EXPECT_FALSE(half.agreesWithMotion(0.85)) << "a small step, but nearly all";
}

TEST(PoseCheck, LearnsNothingFromWhatItDoubts) {
  PoseCheck check;
  EXPECT_EQ(agreesWithMotion(check, {0.1, 0.5, 0.35}), (std::vector<bool>{true, false, false}))
      << "0.35 is close to 0.5, but far from 0.1";
}

TEST(PoseCheck, ForgetsOnReset) {
  PoseCheck check;
  EXPECT_EQ(agreesWithMotion(check, {0.1, 0.5}), (std::vector<bool>{true, false}));
  check.reset();
  EXPECT_TRUE(check.agreesWithMotion(0.5));
  EXPECT_EQ(agreesWithMotion(check, {0.75, 0.75, 0.75}), (std::vector<bool>{false, false, true}))
      << "two more may be odd, not one";
}

}  // namespace
}  // namespace predictive_stereo
