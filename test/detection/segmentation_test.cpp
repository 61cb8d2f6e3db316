/// Segments on a wall that the camera passes, and how they grow.
#include "detection/segmentation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

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
    cv::Mat1f static_world;
    seen.compare(seen.static_source, cv::Rect(cv::Point(), frame.lattice()), static_world);
    const cv::Mat1f no_residual(frame.lattice(), -1e6f);
    Hypothesis hypothesis;
    for (cv::Point p : points_px) hypothesis.seeds.push_back(p / 2);
    hypothesis.disparity_px = kMover_px;
    hypothesis.nearest_px = kMover_px + 2;
    hypothesis.farthest_px = farthest_px;
    const double depth_m = rig.disparityTimesDepth() / kMover_px;
    hypothesis.moved_m.x() = -kFlow_px * depth_m / rig.fx_px;
    return segment(seen, static_world, no_residual, hypothesis);
  }
  float farthest_px = kMover_px - 2;
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

// The layer of a far object begins at 0, which is no disparity.
TEST(Segmentation, WhatIsUnknownIsNoPart) {
  BehindAPole scene;
  scene.farthest_px = 0;
  const cv::Rect hole(220, 70, 12, 12);
  scene.disparity(hole).setTo(scene.range.invalid());
  const auto found = scene.find(pointsIn({216, 56, 32, 48}));
  ASSERT_TRUE(found);
  cv::Mat1b mask(scene.frame.lattice(), uchar{0});
  found->mask.copyTo(mask(found->area));
  EXPECT_GT(cv::countNonZero(mask), 300);
  EXPECT_EQ(cv::countNonZero(mask(cv::Rect(hole.tl() / 2, hole.size() / 2))), 0);
}

TEST(Segmentation, WhatNoPointLiesOnIsNoPart) {
  BehindAPole scene;
  const cv::Rect right(216, 56, 32, 48);
  const auto found = scene.find(pointsIn(right));
  ASSERT_TRUE(found);
  EXPECT_GE(2 * found->area.x, 200) << "the part to the left of the pole may be another object";
}

// A layer with a surface, of which motion has revealed a part.
struct Surface {
  cv::Mat1b layer = cv::Mat1b::zeros(60, 120), mask = cv::Mat1b::zeros(60, 120);
  cv::Mat1f support = cv::Mat1f::zeros(60, 120);

  Surface(const cv::Rect& surface, const cv::Rect& shown) {
    layer(surface) = 255;
    mask(shown) = 255;
    support(shown) = 5.0f;
  }
  bool grow() {
    cv::Mat1f smooth;
    cv::boxFilter(support, smooth, CV_32F, {5, 5});
    const cv::Mat1b before = mask.clone();
    growOverLayer(layer, support, smooth, MotionDetectionParams().min_explained, mask);
    return cv::countNonZero(mask != before) > 0;
  }
  cv::Rect box() const { return cv::boundingRect(mask); }
};

TEST(GrownSegment, ReachesTheEdgesOfItsSurface) {
  const cv::Rect car(20, 10, 80, 30);
  Surface surface(car, {30, 12, 30, 25});
  surface.layer(cv::Rect(104, 10, 16, 30)) = 255;  // beyond a gap: another surface
  EXPECT_TRUE(surface.grow());
  EXPECT_EQ(surface.box(), car);
  EXPECT_EQ(cv::countNonZero(surface.mask), car.area());
}

TEST(GrownSegment, DoesNotCrossAThinBridge) {
  Surface surface({20, 10, 40, 30}, {22, 12, 30, 25});
  surface.layer(cv::Rect(66, 10, 40, 30)) = 255;
  surface.layer(cv::Rect(60, 20, 6, 1)) = 255;
  EXPECT_TRUE(surface.grow());
  EXPECT_EQ(surface.box(), cv::Rect(20, 10, 40, 30));
}

TEST(GrownSegment, LeavesOutTheLittleThatContradicts) {
  Surface surface({20, 10, 80, 30}, {30, 12, 30, 25});
  const cv::Rect pole(95, 10, 5, 30);
  surface.support(pole) = -10.0f;
  EXPECT_TRUE(surface.grow());
  EXPECT_EQ(cv::countNonZero(surface.mask(pole)), 0);
  EXPECT_GE(surface.box().br().x, 90);
}

// A pedestrian before a static wall of about the same depth.
TEST(GrownSegment, StaysBeforeAWallThatStandsStill) {
  const cv::Rect shown(40, 20, 20, 30);
  Surface surface({0, 10, 120, 45}, shown);
  for (int y = 12; y < 50; y += 10)
    for (int x = 2; x < 110; x += 10)
      if (x < 35 || x > 65) surface.support(cv::Rect(x, y, 4, 4)) = -10.0f;
  EXPECT_FALSE(surface.grow());
  EXPECT_EQ(surface.box(), shown);
  EXPECT_EQ(cv::countNonZero(surface.mask), shown.area());
}

// The motion of a tiny part of a surface is not that of the surface.
TEST(GrownSegment, StaysWhereItIsATinyPart) {
  const cv::Rect shown(40, 20, 10, 10);
  Surface surface({0, 10, 120, 45}, shown);
  EXPECT_FALSE(surface.grow());
  EXPECT_EQ(surface.box(), shown);
}

TEST(GrownSegment, StaysWhereItsPartsLieInMoreThanOneSurface) {
  Surface surface({20, 10, 20, 30}, {25, 15, 10, 20});
  surface.layer(cv::Rect(60, 10, 20, 30)) = 255;
  surface.mask(cv::Rect(65, 15, 10, 20)) = 255;
  EXPECT_FALSE(surface.grow());
}

}  // namespace
}  // namespace predictive_stereo
