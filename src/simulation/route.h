/// Where the camera is at any time.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "simulation/models.h"
#include "simulation/scene.h"

namespace predictive_stereo::simulation {

/// Pose of the camera's optical frame (z ahead, x to the right) in the vehicle, which stands on the
/// road below it.
Eigen::Isometry3d mountedCamera();

/// The way that a vehicle takes through the town, and how fast it goes along it.
class Route {
 public:
  /// @param duration_s  times from 0 to here are known.
  Route(const Drive& drive, double duration_s, uint32_t seed);

  double wayAt(double time_s) const;    ///< [m] from the start
  double speedAt(double time_s) const;  ///< [m/s]
  /// The vehicle's place this far along the way [m].
  Place placeAlong(double way_m) const;
  Place placeAt(double time_s) const { return placeAlong(wayAt(time_s)); }

  /// Pose of the left camera's optical frame in the world (z up).
  Eigen::Isometry3d cameraAt(double time_s) const;

 private:
  struct State {
    double way_m, speed_mps, accel_mps2;
  };
  State stateAt(double time_s) const;

  Drive drive_;
  uint32_t seed_;
  std::vector<Eigen::Vector3d> path_;  // x, y, heading every kStep of the way
  std::vector<bool> bends_;            // where the path bends
  std::vector<State> states_;          // every kTick
};

}  // namespace predictive_stereo::simulation
