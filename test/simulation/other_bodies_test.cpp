/// The scenes of other bodies than cars: a drone, a robot indoors, a hand-held camera.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <opencv2/core.hpp>

#include "evaluation/simulation/street.h"

namespace predictive_stereo {
namespace {

using Eigen::Vector3d;

StreetParams smallScene(const std::string& name, int frames) {
  StreetParams params;
  params.scene = name;
  params.width = 400;
  params.height = 120;
  params.frames = frames;
  return params;
}

double degreesBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle() * 180 / 3.14159265;
}

TEST(OtherBodies, HaveTheirOwnCameras) {
  StreetParams params;
  params.scene = "drone";
  const Street drone(params);
  EXPECT_EQ(drone.rig().size, cv::Size(752, 480));
  EXPECT_EQ(drone.rig().fx_px, 436);
  EXPECT_EQ(drone.rig().baseline_m, 0.11);
  EXPECT_NEAR(drone.stampOf(1), 0.05, 1e-12);
  params.scene = "street";
  EXPECT_EQ(Street(params).rig().size, cv::Size(1242, 375));
  params.width = 376;
  params.rate_hz = 3;
  params.scene = "drone";
  const Street half(params);
  EXPECT_EQ(half.rig().size, cv::Size(376, 480));
  EXPECT_EQ(half.rig().fx_px, 218);
  EXPECT_NEAR(half.stampOf(1), 1 / 3.0, 1e-12);
}

TEST(OtherBodies, DroneRestsTurnsAndLooksDown) {
  StreetParams params;
  params.scene = "drone";
  params.frames = 300;
  const Street drone(params);
  double largest_m = 0, largest_deg = 0, fastest_deg = 0;
  for (int i = 1; i < 40; ++i) {
    largest_m =
        std::max(largest_m, (drone.poseOf(i).translation() - drone.poseOf(0).translation()).norm());
    largest_deg = std::max(largest_deg, degreesBetween(drone.poseOf(i), drone.poseOf(i - 1)));
  }
  EXPECT_LT(largest_m, 0.001);
  EXPECT_GT(largest_deg, 0.03);  // 0.2 px
  EXPECT_LT(largest_deg, 0.2);
  for (int i = 120; i < 160; ++i)
    fastest_deg = std::max(fastest_deg, degreesBetween(drone.poseOf(i), drone.poseOf(i - 1)));
  EXPECT_NEAR(fastest_deg * 20, 90, 10);
  // Only the floor and its chessboard are visible.
  const StreetFrame frame = drone.render(270);
  const Vector3d down(0, 0, -1);
  EXPECT_GT(down.dot(frame.T_world_cam.linear().col(2)), 0.7);
  for (int y = 0; y < frame.left.rows; y += 7)
    for (int x = 0; x < frame.left.cols; x += 7) {
      const Vector3d point =
          frame.T_world_cam * drone.rig().pointFromDisparity(x, y, frame.disparity_px(y, x));
      ASSERT_NEAR(point.z(), 0.005, 0.006);
    }
}

TEST(OtherBodies, PeoplePassTheRobotNearby) {
  const Street robot(smallScene("robot", 100));
  std::map<int, double> nearest_m;
  for (int i = 2; i < 100; i += 4)
    for (const StreetMover& mover : robot.render(i).movers) {
      EXPECT_EQ(mover.kind, "person");
      auto& nearest = nearest_m.emplace(mover.id, 1e9).first->second;
      nearest = std::min(nearest, mover.distance_m);
    }
  int passing = 0;
  for (const auto& [id, distance_m] : nearest_m) passing += distance_m > 0.5 && distance_m < 6;
  EXPECT_GE(passing, 5);
}

TEST(OtherBodies, HandheldCameraMovesInAllDirections) {
  const Street hand(smallScene("handheld", 200));
  Vector3d largest_m = Vector3d::Zero(), largest_rad = Vector3d::Zero();
  for (int i = 1; i < 200; ++i) {
    const Eigen::Isometry3d T = hand.poseOf(i - 1).inverse() * hand.poseOf(i);
    const Eigen::AngleAxisd turn(T.linear());
    largest_m = largest_m.cwiseMax(T.translation().cwiseAbs());
    largest_rad = largest_rad.cwiseMax((turn.angle() * turn.axis()).cwiseAbs());
  }
  EXPECT_GT(largest_m.minCoeff(), 0.04) << largest_m.transpose();
  EXPECT_GT(largest_rad.minCoeff(), 0.03) << largest_rad.transpose();
}

TEST(OtherBodies, RoomsAreClosed) {
  for (const char* scene : {"drone", "robot"}) {
    const Street street(smallScene(scene, 300));
    for (int i = 3; i < 300; i += 33)
      EXPECT_EQ(cv::countNonZero(street.render(i).disparity_px == 0), 0) << scene << " " << i;
  }
}

}  // namespace
}  // namespace predictive_stereo
