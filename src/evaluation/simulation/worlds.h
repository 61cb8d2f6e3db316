/// Static worlds: an unbounded town of square blocks with streets between them along x and y;
/// indoor worlds with little texture.
#pragma once

#include "evaluation/simulation/scene.h"

namespace predictive_stereo::simulation {

constexpr double kPitch_m = 100;      ///< between the centre lines of neighbouring streets
constexpr double kKerb_m = 6.6;       ///< from a street's centre line to its kerbs
constexpr double kSidewalk_m = 3.2;   ///< width of the pavement between kerb and houses
constexpr double kPavement_m = 0.12;  ///< height of the pavement above the road
constexpr double kLane_m = 1.75;      ///< from a street's centre line to that of a lane

/// Road marking at a point.
struct Marking {
  float strength = 0;     ///< 0: no marking nearby
  float inside_m = 0;     ///< distance to its nearest edge, negative outside
  bool across_u = false;  ///< that edge runs along the world's y
};
Marking markingAt(double x_m, double y_m);

/// The part of the world that a camera can see.
struct View {
  Vector3d position_m;
  Vector2d forward;  ///< unit length
  double tan_half_angle;

  bool reaches(const Vector2d& centre_m, double radius_m) const;
  double distance(const Vector2d& centre_m) const {
    return (centre_m - position_m.head<2>()).norm();
  }
};

/// Adds the houses, gardens, pavements, trees, posts and parked cars in view.
void addTown(const Scene& scene, uint32_t seed, const View& view, Primitives& out);

/// A hall, x from -8 to 16 and y from -8 to 8, 7 m high: a floor without texture with a
/// chessboard, and shelves and machines along the walls.
void addHall(uint32_t seed, Primitives& out);

/// Two corridors with white walls that cross: along x at |y| < 1.25, from -6 to 44, and along y at
/// 13.5 < x < 16, from -22 to 22; 2.7 m high.
void addCorridor(uint32_t seed, Primitives& out);

}  // namespace predictive_stereo::simulation
