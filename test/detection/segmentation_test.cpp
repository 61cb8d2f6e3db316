/// segment() on a wall that the camera passes.
#include "detection/segmentation.h"

#include <gtest/gtest.h>

#include "passing_scene.h"

namespace predictive_stereo {
namespace {

constexpr float kMover_px = 15, kPole_px = 30, kFlow_px = 14;
const cv::Rect kPole(200, 0, 8, kHeight);

float staticShift(float disparity_px) { return kShiftPerDisparity * disparity_px; }

/// An object moves before the wall and behind a pole.
struct BehindAPole : Passing {
  BehindAPole() {
    disparity(kMover).setTo(kMover_px);
    disparity(kPole).setTo(kPole_px);
    shiftInto(kMover, staticShift(kMover_px) + kFlow_px);
    shiftInto(kPole, staticShift(kPole_px));
    previous.disparity_px(kMover + cv::Point(26, 0)).setTo(kMover_px);
    previous.disparity_px(kPole + cv::Point(24, 0)).setTo(kPole_px);
  }
  std::optional<Segment> find(const std::vector<cv::Point>& points_px,
                              const std::optional<GroundPlane>& ground_plane = {}) {
    ground = ground_plane;
    const PastView seen = view();
    Comparison static_world;
    seen.compare(seen.static_source, cv::Rect(cv::Point(), frame.lattice()), static_world);
    const cv::Mat1f no_residual(frame.lattice(), -1e6f);
    LevelGround level;
    level.setFrame(rig, range, disparity);
    Hypothesis hypothesis;
    for (cv::Point p : points_px) hypothesis.seeds.push_back(p / 2);
    hypothesis.disparity_px = kMover_px;
    hypothesis.nearest_px = kMover_px + 2;
    hypothesis.farthest_px = kMover_px - 2;
    const double depth_m = rig.disparityTimesDepth() / kMover_px;
    hypothesis.moved_m.x() = -kFlow_px * depth_m / rig.fx_px;
    SegmentationWork work;
    return segment(seen, {&static_world, no_residual, level}, hypothesis, work);
  }
};

double overlap(const Segment& segment, const cv::Rect& truth) {
  const cv::Rect box(2 * segment.area.x, 2 * segment.area.y, 2 * segment.area.width,
                     2 * segment.area.height);
  return static_cast<double>((box & truth).area()) / (box | truth).area();
}

TEST(Segmentation, WhatIsLowBesideItIsNoPart) {
  const cv::Rect visible(208, 48, 48, 64);
  // The object stands on it: the lower end has its disparity there.
  GroundPlane ground;
  ground.b = kMover_px / (kMover.br().y - kHeight / 2);
  ground.c = -ground.b * kHeight / 2;
  const auto findWith = [&](const cv::Rect& strip, bool has_ground) {
    // It moves with the object.
    BehindAPole scene;
    ground.camera_height_m = scene.rig.baseline_m / ground.b;
    scene.disparity(strip).setTo(kMover_px);
    scene.shiftInto(strip, staticShift(kMover_px) + kFlow_px);
    scene.previous.disparity_px(strip + cv::Point(26, 0)).setTo(kMover_px);
    return scene.find(pointsIn({216, 56, 32, 48}),
                      has_ground ? std::optional(ground) : std::nullopt);
  };
  const cv::Rect shadow(240, 100, 100, 10), arm(240, 60, 100, 10);
  const auto without_shadow = findWith(shadow, true), with_shadow = findWith(shadow, false),
             with_arm = findWith(arm, true);
  ASSERT_TRUE(without_shadow && with_shadow && with_arm);
  EXPECT_GT(overlap(*without_shadow, visible), 0.7) << 2 * without_shadow->area.br().x;
  EXPECT_GT(2 * with_shadow->area.br().x, 320) << "no ground is known";
  EXPECT_GT(2 * with_arm->area.br().x, 320);
}

TEST(Segmentation, WhatNoPointLiesOnIsNoPart) {
  BehindAPole scene;
  const cv::Rect right(216, 56, 32, 48);
  const auto found = scene.find(pointsIn(right));
  ASSERT_TRUE(found);
  EXPECT_GE(2 * found->area.x, 200) << "the part to the left of the pole may be another object";
}

}  // namespace
}  // namespace predictive_stereo
