/// What the static world does not explain, and where it came from, on a wall that the camera
/// passes.
#include "detection/suspect_groups.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "detection/unexplained_points.h"

namespace predictive_stereo {
namespace {

constexpr int kWidth = 400, kHeight = 160;
constexpr float kWall_px = 10, kStaticShift_px = 8, kShiftPerDisparity = 0.8f;

/// A wall of noise, square to the camera, which moves to the right. Parts of it move by themselves.
struct Passing {
  Passing() : now(kHeight, kWidth), before(kHeight, kWidth) {
    rig.size = {kWidth, kHeight};
    rig.fx_px = rig.fy_px = 300;
    rig.cx_left_px = rig.cx_right_px = kWidth / 2;
    rig.cy_px = kHeight / 2;
    rig.baseline_m = 0.5;
    T_prev_cam.translation().x() = kShiftPerDisparity * rig.baseline_m;
    cv::RNG rng(7);
    rng.fill(now, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(now, now, {7, 7}, 2);
    cv::normalize(now, now, 0, 255, cv::NORM_MINMAX);
    shiftInto(cv::Rect(0, 0, kWidth, kHeight), kStaticShift_px);
    disparity = cv::Mat1f(kHeight, kWidth, kWall_px);
    variance = cv::Mat1f(kHeight, kWidth, 0.1f);
    disparity.copyTo(previous.disparity_px);
  }
  void shiftInto(cv::Rect part, float shift_px) {
    const int shift = static_cast<int>(shift_px);
    part.width = std::min(part.width, kWidth - shift - part.x);
    now(part).copyTo(before(part + cv::Point(shift, 0)));
  }
  /// What is seen in this part now was so far to the right of where it would have stood.
  void move(const cv::Rect& part, float by_px) { shiftInto(part, kStaticShift_px + by_px); }
  TrackingView view() {
    current.build(now, 4);
    previous.pyramid.build(before, 4);
    return {rig, range, current, disparity, variance, previous, T_prev_cam};
  }
  std::vector<cv::Point> unexplained(const std::vector<cv::Point>& points_px) {
    std::vector<cv::Point> kept;
    unexplainedPoints(view(), params, kSeconds, points_px, kept);
    return kept;
  }

  static constexpr double kSeconds = 0.1;
  StereoRig rig;
  DisparityRange range{0, 64};
  Eigen::Isometry3d T_prev_cam = Eigen::Isometry3d::Identity();
  cv::Mat1b now, before;
  cv::Mat1f disparity, variance;
  ImagePyramid current;
  RememberedFrame previous;
  MotionDetectionParams params;
};

std::vector<cv::Point> pointsIn(const cv::Rect& part) {
  std::vector<cv::Point> points;
  for (int y = part.y; y < part.br().y; y += 8)
    for (int x = part.x; x < part.br().x; x += 8) points.emplace_back(x, y);
  return points;
}

const cv::Rect kAll(24, 24, 320, 112), kMover(160, 48, 96, 64);
const cv::Rect kWithin(168, 56, 80, 48);  // the mover, by more than a patch

TEST(UnexplainedPoints, LeavesWhatStandsOut) {
  Passing scene;
  EXPECT_TRUE(scene.unexplained(pointsIn(kAll)).empty());
}

TEST(UnexplainedPoints, KeepsWhatMoves) {
  Passing scene;
  scene.move(kMover, 14);
  EXPECT_EQ(scene.unexplained(pointsIn(kWithin)), pointsIn(kWithin));
}

TEST(UnexplainedPoints, AllowForDisparitiesThatAreOff) {
  Passing scene;
  scene.disparity += 1.4f;
  EXPECT_TRUE(scene.unexplained(pointsIn(kAll)).empty());
  scene.disparity += 6.0f;
  EXPECT_EQ(scene.unexplained(pointsIn(kAll)), pointsIn(kAll));
  for (int y = 0; y < kHeight; y += 8) scene.disparity.row(y + 4).setTo(kWall_px);
  EXPECT_TRUE(scene.unexplained(pointsIn(kAll)).empty()) << "the right one is 4 px away";
}

TEST(UnexplainedPoints, LeavesWhatWasJustUncoveredOut) {
  Passing scene;
  scene.move(kMover, 14);
  scene.previous.disparity_px.setTo(3 * kWall_px);
  EXPECT_TRUE(scene.unexplained(pointsIn(kWithin)).empty());
  scene.previous.disparity_px.setTo(1.1f * kWall_px);
  EXPECT_FALSE(scene.unexplained(pointsIn(kWithin)).empty()) << "it may have been that near itself";
}

TEST(UnexplainedPoints, LooksAtAnEvenSample) {
  Passing scene;
  scene.move(kMover, 14);
  std::vector<cv::Point> many;
  for (int k = 0; k < 100; ++k)
    for (cv::Point p : pointsIn(kWithin)) many.push_back(p);
  ASSERT_EQ(many.size(), 6000u);
  const std::vector<cv::Point> kept = scene.unexplained(many);
  ASSERT_EQ(kept.size(), 3000u);
  for (size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i], many[2 * i]);
  EXPECT_TRUE(scene.unexplained({}).empty());
}

TEST(SuspectGroups, AreFoundAsAWhole) {
  Passing scene;
  scene.move(kMover, 22);
  const auto groups =
      groupSuspects(scene.view(), scene.params, pointsIn(kWithin), Passing::kSeconds);
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0].points_px, pointsIn(kWithin));
  EXPECT_EQ(groups[0].shift_px, cv::Point2f(22, 0));
  EXPECT_GT(groups[0].gain, 3);
}

TEST(SuspectGroups, WhatStandsIsNone) {
  Passing scene;
  EXPECT_TRUE(
      groupSuspects(scene.view(), scene.params, pointsIn(kWithin), Passing::kSeconds).empty());
}

TEST(SuspectGroups, AreNoWiderThanAVehicleNorDeeper) {
  Passing scene;
  scene.move(kAll, 14);
  scene.disparity.rowRange(80, kHeight).setTo(2 * kWall_px);
  scene.previous.disparity_px.rowRange(80, kHeight).setTo(2 * kWall_px);
  for (const SuspectGroup& group :
       groupSuspects(scene.view(), scene.params, pointsIn(kAll), Passing::kSeconds)) {
    const float d = scene.disparity(group.points_px.front());
    for (cv::Point p : group.points_px) {
      EXPECT_EQ(scene.disparity(p), d);
      EXPECT_LE(cv::norm(p - group.points_px.front()), 2.5 * d / scene.rig.baseline_m);
    }
  }
}

TEST(SuspectGroups, FewPointsAreNoGroup) {
  Passing scene;
  scene.move(kMover, 14);
  std::vector<cv::Point> points = pointsIn(kWithin);
  points.resize(static_cast<size_t>(scene.params.min_tracks) - 1);
  EXPECT_TRUE(groupSuspects(scene.view(), scene.params, points, Passing::kSeconds).empty());
}

TEST(SuspectGroups, PointsThatAreLostFollowTheOthers) {
  Passing scene;
  // Half of the mover is too smooth for Lucas-Kanade.
  cv::GaussianBlur(scene.now(cv::Rect(160, 48, 48, 64)), scene.now(cv::Rect(160, 48, 48, 64)),
                   {31, 31}, 12);
  scene.now(cv::Rect(176, 64, 24, 32)).setTo(scene.now(64, 176));
  scene.move(kMover, 14);
  const TrackingView view = scene.view();
  const auto alone = followPoints(view, scene.params, pointsIn(kWithin), {14, 0});
  EXPECT_LT(alone.size(), pointsIn(kWithin).size());
  const auto tracks = followGroups(
      view, scene.params, groupSuspects(view, scene.params, pointsIn(kWithin), Passing::kSeconds));
  ASSERT_EQ(tracks.size(), pointsIn(kWithin).size());
  for (const PointTrack& track : tracks) {
    EXPECT_NEAR(track.flow().x(), 14, 1) << track.position;
    EXPECT_NEAR(track.flow().y(), 0, 1) << track.position;
    EXPECT_TRUE(track.moving);
  }
}

TEST(SuspectGroups, AtMostSoManyPointsAreFollowed) {
  Passing scene;
  scene.move(kMover, 14);
  scene.params.max_tracks = 20;
  const TrackingView view = scene.view();
  const auto groups = groupSuspects(view, scene.params, pointsIn(kWithin), Passing::kSeconds);
  const auto tracks = followGroups(view, scene.params, groups);
  EXPECT_LE(tracks.size(), 20u);
  EXPECT_GE(tracks.size(), 10u);
}

}  // namespace
}  // namespace predictive_stereo
