#include "evaluation/simulation/path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <vector>

#include "evaluation/simulation/traffic.h"

namespace predictive_stereo::simulation {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kRadPerDeg = 3.14159265358979 / 180;

const std::vector<Waypoint> kWaypoints = {
    {0, {0, 0, 0}, 0, 0, 0},    {1, {0, 0, 0}, 0, 0, 0},      {2, {1, -1, 2}, 10, 5, 0},
    {3, {2, -1, 3}, 100, 0, 0}, {4, {3, -1, 3}, 190, -5, 20}, {6, {3, -1, 3}, 190, -5, 20}};

Isometry3d poseOf(const Waypoint& w) {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = (Eigen::AngleAxisd(w.heading_deg * kRadPerDeg, Vector3d::UnitZ()) *
                Eigen::AngleAxisd(w.pitch_deg * kRadPerDeg, Vector3d::UnitY()) *
                Eigen::AngleAxisd(w.roll_deg * kRadPerDeg, Vector3d::UnitX()))
                   .toRotationMatrix();
  T.translation() = w.position_m;
  return T;
}

TEST(WaypointPath, PassesThroughItsWaypoints) {
  const WaypointPath path(kWaypoints, {}, 1);
  for (const Waypoint& w : kWaypoints)
    EXPECT_TRUE(path.bodyAt(w.time_s).isApprox(poseOf(w), 1e-12)) << w.time_s;
  EXPECT_TRUE(path.bodyAt(-1).isApprox(poseOf(kWaypoints.front()), 1e-12));
  EXPECT_TRUE(path.bodyAt(9).isApprox(poseOf(kWaypoints.back()), 1e-12));
}

TEST(WaypointPath, StandsStillBetweenEqualWaypoints) {
  const WaypointPath path(kWaypoints, {}, 1);
  for (double t = 0; t <= 1; t += 0.1)
    EXPECT_EQ(path.bodyAt(t).matrix(), path.bodyAt(0).matrix()) << t;
  for (double t = 2; t <= 4; t += 0.1) EXPECT_NEAR(path.bodyAt(t).translation().y(), -1, 1e-12);
}

TEST(WaypointPath, IsSmoothAndDoesNotOvershoot) {
  const WaypointPath path(kWaypoints, {}, 1);
  constexpr double kStep_s = 1e-3;
  Vector3d speed_before = Vector3d::Zero();
  double height_before = 0;
  for (double t = 0; t < 6; t += kStep_s) {
    const Isometry3d before = path.bodyAt(t), after = path.bodyAt(t + kStep_s);
    const Vector3d speed = (after.translation() - before.translation()) / kStep_s;
    EXPECT_LT((speed - speed_before).norm(), 0.05) << t;  // 50 m/s^2 would be a jump
    EXPECT_GE(after.translation().z(), height_before - 1e-12) << t;
    EXPECT_LE(after.translation().z(), 3 + 1e-12) << t;
    speed_before = speed;
    height_before = after.translation().z();
  }
}

TEST(WaypointPath, ShakesWithinTheirTimeAndSize) {
  const Shake shake{2, 4, 0.01, 1, 0.1};
  const WaypointPath still(kWaypoints, {}, 1), shaken(kWaypoints, {shake}, 1),
      other(kWaypoints, {shake}, 2);
  double largest_m = 0, largest_deg = 0, apart_m = 0;
  for (double t = 0; t < 6; t += 0.013) {
    const Isometry3d offset = still.bodyAt(t).inverse() * shaken.bodyAt(t);
    const double angle_deg = Eigen::AngleAxisd(offset.linear()).angle() / kRadPerDeg;
    if (t < 2 || t > 4) {
      EXPECT_TRUE(offset.isApprox(Isometry3d::Identity(), 1e-12)) << t;
    }
    largest_m = std::max(largest_m, offset.translation().norm());
    largest_deg = std::max(largest_deg, angle_deg);
    apart_m =
        std::max(apart_m, (other.bodyAt(t).translation() - shaken.bodyAt(t).translation()).norm());
  }
  EXPECT_GT(largest_m, 0.005);
  EXPECT_LE(largest_m, 0.01 * std::sqrt(3));
  EXPECT_GT(largest_deg, 0.5);
  EXPECT_LE(largest_deg, 1.05 * std::sqrt(3));
  EXPECT_GT(apart_m, 0.005) << "another seed shakes otherwise";
}

TEST(WaypointPath, RefusesWaypointsOutOfOrder) {
  EXPECT_THROW(WaypointPath({}, {}, 1), std::invalid_argument);
  EXPECT_THROW(WaypointPath({kWaypoints[1], kWaypoints[0]}, {}, 1), std::invalid_argument);
}

TEST(Walks, GoFromOnePointToTheOther) {
  const WaypointPath path(kWaypoints, {}, 1);
  Traffic traffic;
  traffic.walks = {{Kind::kPerson, {5, 3}, {5, 9}, 2, 1.5}};
  const std::vector<Mover> movers = makeTraffic(traffic, path, {0.5, 0.5, 0.5}, 10, 1);
  ASSERT_EQ(movers.size(), 1U);
  const Mover& walker = movers[0];
  EXPECT_EQ(walker.from_s, 2);
  EXPECT_NEAR(walker.until_s, 6, 1e-9);
  EXPECT_TRUE(walker.placeAt(2, path).position_m.isApprox(Vector3d(5, 3, 0), 1e-9));
  EXPECT_TRUE(walker.placeAt(6, path).position_m.isApprox(Vector3d(5, 9, 0), 1e-9));
  EXPECT_TRUE(walker.velocityAt(4, path).isApprox(Vector3d(0, 1.5, 0), 1e-6));
}

TEST(Walks, MayNotMeetTheCameraOrEachOther) {
  const WaypointPath path(kWaypoints, {}, 1);
  const Vector3d body(0.5, 0.5, 0.5);
  Traffic traffic;
  traffic.walks = {{Kind::kPerson, {3, -5}, {3, 5}, 0, 1}};
  EXPECT_THROW(makeTraffic(traffic, path, body, 10, 1), std::invalid_argument);
  traffic.walks = {{Kind::kPerson, {9, 0}, {9, 9}, 0, 1}, {Kind::kPerson, {9, 9}, {9, 0}, 0, 1}};
  EXPECT_THROW(makeTraffic(traffic, path, body, 10, 1), std::invalid_argument);
}

TEST(Passers, CrossTheViewOfAStandingCameraNearIt) {
  const WaypointPath path({{0, {-6, 0, 0}, 0, 0, 0}, {60, {-6, 0, 0}, 0, 0, 0}}, {}, 1);
  Traffic traffic;
  traffic.passers_s = 1.5;
  std::vector<double> distances_m;
  for (uint32_t seed = 1; seed <= 10; ++seed)
    for (const Mover& person : makeTraffic(traffic, path, {0.5, 0.5, 1}, 60, seed)) {
      EXPECT_EQ(person.kind, Kind::kPerson);
      const Vector3d ahead = person.placeAt(person.met_s, path).position_m - Vector3d(-6, 0, 0);
      EXPECT_NEAR(ahead.y(), 0, 1e-9);
      distances_m.push_back(ahead.x());
      const double begins_m = person.placeAt(person.from_s, path).position_m.y();
      const double ends_m = person.placeAt(person.until_s, path).position_m.y();
      EXPECT_LT(begins_m * ends_m, 0) << "from one side to the other";
    }
  EXPECT_GT(distances_m.size(), 150U);
  const auto [nearest_m, farthest_m] = std::minmax_element(distances_m.begin(), distances_m.end());
  std::printf("%zu people at %.2f to %.2f m\n", distances_m.size(), *nearest_m, *farthest_m);
  EXPECT_GE(*nearest_m, 0.8);
  EXPECT_LT(*nearest_m, 1.5);
  EXPECT_GT(*farthest_m, 5);
  EXPECT_LE(*farthest_m, 6);
}

}  // namespace
}  // namespace predictive_stereo::simulation
