/// The way of a vehicle through the town.
#pragma once

#include "simulation/path.h"

namespace predictive_stereo::simulation {

/// Which streets a vehicle takes, and how fast it goes along them.
class Route : public Path {
 public:
  /// @param duration_s  times from 0 to here are known.
  Route(const Drive& drive, double duration_s, uint32_t seed);

  double wayAt(double time_s) const;    ///< [m] from the start
  double speedAt(double time_s) const;  ///< [m/s]
  /// The vehicle's place this far along the way [m].
  Place placeAlong(double way_m) const;
  Place placeAhead(double time_s, double gap_m) const override {
    return placeAlong(wayAt(time_s) + gap_m);
  }
  Eigen::Isometry3d bodyAt(double time_s) const override;

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
