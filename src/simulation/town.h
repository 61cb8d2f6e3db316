/// The static world: an endless town of square blocks, streets between them along x and along y.
#pragma once

#include "simulation/models.h"

namespace predictive_stereo::simulation {

constexpr double kPitch_m = 100;      ///< from one street's middle to the next one's
constexpr double kKerb_m = 6.6;       ///< from a street's middle to its kerbs
constexpr double kSidewalk_m = 3.2;   ///< width of the pavement between kerb and houses
constexpr double kPavement_m = 0.12;  ///< height of the pavement above the road
constexpr double kLane_m = 1.75;      ///< from a street's middle to the middle of a lane

/// What is painted on the road at a point.
struct Marking {
  float strength = 0;     ///< 0: nothing near
  float inside_m = 0;     ///< distance to its nearest edge, negative outside
  bool across_u = false;  ///< that edge runs along the world's y
};
Marking markingAt(double x_m, double y_m);

/// The part of the world that a camera can see.
struct View {
  Eigen::Vector3d position_m;
  Eigen::Vector2d forward;  ///< unit length
  double tan_half_angle;
  bool all_around = false;  ///< also what lies behind the camera: mirrors show it

  bool reaches(const Eigen::Vector2d& centre_m, double radius_m) const;
  double distance(const Eigen::Vector2d& centre_m) const {
    return (centre_m - position_m.head<2>()).norm();
  }
};

struct TownParams {
  uint32_t seed = 1;
  double parked_cars = 0.5;  ///< share of the parking places that are taken
  double trees = 0.5;        ///< share of the places for trees that have one
};

void addTown(const TownParams& params, const View& view, Primitives& out);

}  // namespace predictive_stereo::simulation
