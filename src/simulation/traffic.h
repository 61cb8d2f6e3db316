/// Everybody else who moves.
#pragma once

#include <vector>

#include "simulation/path.h"

namespace predictive_stereo::simulation {

/// A thing that moves along the ground at constant velocity, or goes along with the camera.
struct Mover {
  int id = 0;
  Kind kind = Kind::kCar;
  uint32_t seed = 0;
  double from_s = 0, until_s = 0;  ///< when it is there
  bool goes_along = false;
  Companion along;   ///< where it does; gap_m to its middle
  double met_s = 0;  ///< when it is at `met`
  Place met;
  double speed_mps = 0;

  Place placeAt(double time_s, const Path& path) const;
  Eigen::Vector3d velocityAt(double time_s, const Path& path) const;
  double strideAt(double time_s) const { return speed_mps * (time_s - met_s) + 0.1 * id; }

 private:
  double gapAt(double time_s) const;
};

/// The movers of a scene, none of which drives through another one or the camera's body (length,
/// width, height). Deterministic.
/// @throws std::invalid_argument for a walk that meets the body or another walk.
std::vector<Mover> makeTraffic(const Traffic& traffic, const Path& path,
                               const Eigen::Vector3d& body_m, double duration_s, uint32_t seed);

}  // namespace predictive_stereo::simulation
