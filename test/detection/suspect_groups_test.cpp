/// Groups of points that contradict a static scene, and their motion, on a wall that the camera
/// passes.
#include "detection/suspect_groups.h"

#include <gtest/gtest.h>

#include "detection/constants.h"
#include "detection/unexplained_points.h"
#include "passing_scene.h"

namespace predictive_stereo {
namespace {

std::vector<cv::Point> unexplained(Passing& scene, const std::vector<cv::Point>& points_px) {
  std::vector<cv::Point> kept;
  unexplainedPoints(scene.view(), points_px, kept);
  return kept;
}

TEST(UnexplainedPoints, LeavesWhatStandsOut) {
  Passing scene;
  EXPECT_TRUE(unexplained(scene, pointsIn(kAll)).empty());
}

TEST(UnexplainedPoints, KeepsWhatMoves) {
  Passing scene;
  scene.move(kMover, 14);
  EXPECT_EQ(unexplained(scene, pointsIn(kWithin)), pointsIn(kWithin));
}

TEST(UnexplainedPoints, AllowForDisparitiesThatAreOff) {
  Passing scene;
  scene.disparity += 1.4f;
  EXPECT_TRUE(unexplained(scene, pointsIn(kAll)).empty());
  scene.disparity += 6.0f;
  EXPECT_EQ(unexplained(scene, pointsIn(kAll)), pointsIn(kAll));
  for (int y = 0; y < kHeight; y += 8) scene.disparity.row(y + 4).setTo(kWall_px);
  EXPECT_TRUE(unexplained(scene, pointsIn(kAll)).empty()) << "the right one is 4 px away";
}

TEST(UnexplainedPoints, LeavesWhatWasJustUncoveredOut) {
  Passing scene;
  scene.move(kMover, 14);
  scene.previous.disparity_px.setTo(3 * kWall_px);
  EXPECT_TRUE(unexplained(scene, pointsIn(kWithin)).empty());
  scene.previous.disparity_px.setTo(1.1f * kWall_px);
  EXPECT_FALSE(unexplained(scene, pointsIn(kWithin)).empty())
      << "it may have been that near itself";
}

TEST(UnexplainedPoints, UnknownDisparitiesHideNothing) {
  const DisparityRange all{0, 64}, range{static_cast<int>(kWall_px), 64};
  const std::vector<cv::Point> middle = {{kWidth / 2, kHeight / 2}};
  Passing scene;
  scene.move(kAll, 14);
  scene.T_prev_cam.translation() = Eigen::Vector3d(0, 0, 5);  // 15 m ahead, 20 m then
  scene.previous.disparity_px.setTo(range.invalid());
  scene.range = all;
  EXPECT_TRUE(unexplained(scene, middle).empty());
  scene.range = range;
  EXPECT_EQ(unexplained(scene, middle), middle);
}

TEST(UnexplainedPoints, LooksAtAnEvenSample) {
  Passing scene;
  scene.move(kMover, 14);
  std::vector<cv::Point> many;
  for (int k = 0; k < 100; ++k)
    for (cv::Point p : pointsIn(kWithin)) many.push_back(p);
  ASSERT_EQ(many.size(), 4200u);
  const std::vector<cv::Point> kept = unexplained(scene, many);
  ASSERT_EQ(kept.size(), 2100u);
  for (size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i], many[2 * i]);
  EXPECT_TRUE(unexplained(scene, {}).empty());
}

TEST(SuspectGroups, AreFoundAsAWhole) {
  Passing scene;
  scene.move(kMover, 22);
  const std::vector<cv::Point> points = pointsIn({200, 56, 40, 32});
  const auto groups = groupSuspects(scene.view(), points);
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0].points_px, points);
  EXPECT_EQ(groups[0].shift_px, cv::Point2f(22, 0));
  EXPECT_GT(groups[0].gain, 3);
}

TEST(SuspectGroups, UnknownDisparitiesDoNotBelongToThem) {
  const std::vector<cv::Point> points = pointsIn({200, 56, 40, 32});
  const auto groupsWith = [&](const DisparityRange& range) {
    Passing scene;
    scene.range = range;
    scene.disparity.setTo(range.invalid());
    for (cv::Point p : points) scene.disparity(p) = kWall_px;
    scene.move(kMover, 22);
    return groupSuspects(scene.view(), points);
  };
  const auto far_from_unknown = groupsWith({0, 64});
  const auto near_to_unknown = groupsWith({static_cast<int>(kWall_px), 64});
  ASSERT_EQ(far_from_unknown.size(), 1u);
  ASSERT_EQ(near_to_unknown.size(), 1u);
  EXPECT_EQ(near_to_unknown[0].shift_px, far_from_unknown[0].shift_px);
  EXPECT_EQ(near_to_unknown[0].gain, far_from_unknown[0].gain);
}

TEST(SuspectGroups, WhatStandsIsNone) {
  Passing scene;
  EXPECT_TRUE(groupSuspects(scene.view(), pointsIn(kWithin)).empty());
}

TEST(SuspectGroups, AreNoWiderThanAVehicleNorDeeper) {
  Passing scene;
  scene.move(kAll, 14);
  scene.disparity.rowRange(80, kHeight).setTo(2 * kWall_px);
  scene.previous.disparity_px.rowRange(80, kHeight).setTo(2 * kWall_px);
  for (const SuspectGroup& group : groupSuspects(scene.view(), pointsIn(kAll))) {
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
  EXPECT_TRUE(groupSuspects(scene.view(), points).empty());
}

TEST(PointTracks, AnErrorThatAllDisparitiesHaveInCommonIsNoMotion) {
  Passing scene;
  scene.disparity += 4.0f;
  scene.previous.disparity_px += 4.0f;
  const PastView view = scene.view();
  auto tracks = followPoints(view, pointsIn(kWithin));
  classify(view, tracks);
  ASSERT_GT(tracks.size(), 20u);
  for (const PointTrack& track : tracks) {
    EXPECT_NEAR(track.flow().x(), -4 * kShiftPerDisparity, 0.5);
    EXPECT_FALSE(track.moving) << track.position;
  }
}

TEST(SuspectGroups, AtMostSoManyPointsAreFollowed) {
  Passing scene;
  SuspectGroup group;
  while (group.points_px.size() < 3 * DetectionConstants::kMostTracks)
    for (cv::Point p_px : pointsIn(kAll)) group.points_px.push_back(p_px);
  const auto tracks = followGroups(scene.view(), {group});
  EXPECT_LE(tracks.size(), DetectionConstants::kMostTracks);
  EXPECT_GE(tracks.size(), DetectionConstants::kMostTracks / 2);
}

}  // namespace
}  // namespace predictive_stereo
