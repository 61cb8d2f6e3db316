/// Moving objects of a scene.
#pragma once

#include <vector>

#include "evaluation/simulation/path.h"

namespace predictive_stereo::simulation {

/// An object that moves along the ground at constant velocity, or drives with the camera.
struct Mover {
  int id = 0;
  Kind kind = Kind::kCar;
  uint32_t seed = 0;
  double from_s = 0, until_s = 0;  ///< when it exists
  bool goes_along = false;         ///< drives with the camera, see `along`
  Companion along;                 ///< its gap_m is that to the middle
  double met_s = 0;                ///< time at which it is at `met`
  Place met;
  double speed_mps = 0;

  Place placeAt(double time_s, const Path& path) const;
  Vector3d velocityAt(double time_s, const Path& path) const;
  double strideAt(double time_s) const { return speed_mps * (time_s - met_s) + 0.1 * id; }
};

/// The moving objects of a scene. None collides with another one or with the camera's body (length,
/// width, height). Deterministic.
/// @throws std::invalid_argument for a walk that collides with the body or with another walk.
std::vector<Mover> makeTraffic(const Traffic& traffic, const Path& path, const Vector3d& body_m,
                               double duration_s, uint32_t seed);

}  // namespace predictive_stereo::simulation
