/// Groups of points that contradict a static scene, and their motion, on a wall that the camera
/// passes.
#include "detection/across_channel.h"

#include <gtest/gtest.h>

#include "passing_scene.h"

namespace predictive_stereo {
namespace {

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
  const auto tracks = followPoints(scene.view(), pointsIn(kWithin));
  ASSERT_GT(tracks.size(), 20u);
  for (const PointTrack& track : tracks) {
    EXPECT_NEAR(track.flow().x(), -4 * kShiftPerDisparity, 0.5);
    EXPECT_FALSE(track.moving) << track.position;
  }
}

TEST(SuspectGroups, AtMostSoManyPointsAreFollowed) {
  Passing scene;
  SuspectGroup group;
  while (group.points_px.size() < 3 * kMostTracks)
    for (cv::Point p_px : pointsIn(kAll)) group.points_px.push_back(p_px);
  const auto tracks = followGroups(scene.view(), {group});
  EXPECT_LE(tracks.size(), kMostTracks);
  EXPECT_GE(tracks.size(), kMostTracks / 2);
}

}  // namespace
}  // namespace predictive_stereo
