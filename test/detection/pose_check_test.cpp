/// When a pose counts as wrong: sequences of the contradicting share, frame by frame.
#include "detection/pose_check.h"

#include <gtest/gtest.h>

#include <vector>

namespace predictive_stereo {
namespace {

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
