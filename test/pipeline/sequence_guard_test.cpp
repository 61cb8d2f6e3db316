#include "predictive_stereo/sequence_guard.h"

#include <gtest/gtest.h>

namespace predictive_stereo {
namespace {

using Verdict = SequenceGuard::Verdict;

StereoRig rig(double fx_px = 700, int width = 640) {
  Matrix34d left = Matrix34d::Zero();
  left(0, 0) = left(1, 1) = fx_px;
  left(0, 2) = 320;
  left(1, 2) = 240;
  left(2, 2) = 1;
  Matrix34d right = left;
  right(0, 3) = -0.5 * fx_px;
  return StereoRig::fromProjections(left, right, {width, 480});
}

TEST(SequenceGuard, frames_go_on_from_each_other_up_to_the_gap) {
  SequenceGuard guard(1.0);
  EXPECT_EQ(guard.next(stampFromSeconds(10.0), rig()).verdict, Verdict::kFirst);
  EXPECT_EQ(guard.next(stampFromSeconds(10.1), rig()).verdict, Verdict::kContinues);
  EXPECT_EQ(guard.next(stampFromSeconds(11.1), rig()).verdict, Verdict::kContinues);
  const SequenceGuard::Result gap = guard.next(stampFromSeconds(12.2), rig());
  EXPECT_EQ(gap.verdict, Verdict::kBroken);
  EXPECT_EQ(gap.reason, "no frame for 1.1 s, more than max_gap = 1 s: starting anew");
  EXPECT_EQ(guard.next(stampFromSeconds(12.3), rig()).verdict, Verdict::kContinues);
}

TEST(SequenceGuard, a_stamp_that_comes_again_is_no_frame) {
  SequenceGuard guard(1.0);
  guard.next(stampFromSeconds(10.0), rig());
  EXPECT_EQ(guard.next(stampFromSeconds(10.0), rig()).verdict, Verdict::kDuplicate);
  // Also with another calibration: the previous frame remains the last one.
  EXPECT_EQ(guard.next(stampFromSeconds(10.0), rig(701)).verdict, Verdict::kDuplicate);
  EXPECT_EQ(guard.next(stampFromSeconds(10.1), rig()).verdict, Verdict::kContinues);
}

// As when a driver swaps two pairs: the pose must not start at the origin again.
TEST(SequenceGuard, a_late_frame_is_ignored) {
  SequenceGuard guard(1.0);
  guard.next(stampFromSeconds(10.0), rig());
  guard.next(stampFromSeconds(10.2), rig());
  const SequenceGuard::Result late = guard.next(stampFromSeconds(10.1), rig());
  EXPECT_EQ(late.verdict, Verdict::kLate);
  EXPECT_TRUE(late.isIgnored());
  EXPECT_FALSE(late.startsAnew());
  EXPECT_EQ(late.reason.find("the pair is 0.1 s older than the one before, and is ignored"), 0u);
  EXPECT_TRUE(guard.next(stampFromSeconds(9.7), rig()).isIgnored());
  EXPECT_EQ(guard.next(stampFromSeconds(10.3), rig()).verdict, Verdict::kContinues);
  EXPECT_EQ(guard.next(stampFromSeconds(9.75), rig()).verdict, Verdict::kBackward);
}

TEST(SequenceGuard, time_that_goes_back_is_told) {
  SequenceGuard guard(1.0);
  guard.next(stampFromSeconds(10.0), rig());
  const SequenceGuard::Result back = guard.next(stampFromSeconds(5.5), rig());
  EXPECT_EQ(back.verdict, Verdict::kBackward);
  EXPECT_EQ(back.reason, "stamps went back by 4.5 s: starting anew");
  EXPECT_EQ(guard.next(stampFromSeconds(5.6), rig()).verdict, Verdict::kContinues);
}

TEST(SequenceGuard, another_calibration_or_size_breaks_the_sequence) {
  SequenceGuard guard(1.0);
  guard.next(stampFromSeconds(10.0), rig());
  const SequenceGuard::Result calibration = guard.next(stampFromSeconds(10.1), rig(701));
  EXPECT_EQ(calibration.verdict, Verdict::kBroken);
  EXPECT_EQ(calibration.reason, "calibration changed: starting anew");
  const SequenceGuard::Result size = guard.next(stampFromSeconds(10.2), rig(701, 656));
  EXPECT_EQ(size.verdict, Verdict::kBroken);
  EXPECT_EQ(size.reason, "image size changed: starting anew");
  EXPECT_EQ(guard.next(stampFromSeconds(10.3), rig(701, 656)).verdict, Verdict::kContinues);
}

TEST(SequenceGuard, forgetting_makes_the_next_frame_a_first_one) {
  SequenceGuard guard(1.0);
  guard.next(stampFromSeconds(10.0), rig());
  guard.forget();
  EXPECT_EQ(guard.next(stampFromSeconds(10.0), rig()).verdict, Verdict::kFirst);
}

}  // namespace
}  // namespace predictive_stereo
