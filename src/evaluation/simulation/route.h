/// Trajectory of a vehicle through the town.
#pragma once

#include "evaluation/simulation/path.h"

namespace predictive_stereo::simulation {

/// Path of a vehicle along the streets, and its speed profile.
class Route : public Path {
 public:
  /// @param duration_s  the trajectory is computed from 0 to this time.
  Route(const Drive& drive, double duration_s, uint32_t seed);

  /// Place on the path at this distance from its start.
  Place placeAlong(double way_m) const;
  Place placeAhead(double time_s, double gap_m) const override {
    return placeAlong(stateAt(time_s).way_m + gap_m);
  }
  Eigen::Isometry3d bodyAt(double time_s) const override;

 private:
  struct State {
    double way_m, speed_mps, accel_mps2;
  };
  void layPath(double length_m);
  std::vector<double> speedLimits(const std::vector<double>& stops) const;
  void driveAlong(const std::vector<double>& stops, const std::vector<double>& limit, size_t ticks);
  State stateAt(double time_s) const;

  Drive drive_;
  uint32_t seed_;
  std::vector<Eigen::Vector3d> path_;  // x, y, heading at every kStep of distance
  std::vector<bool> bends_;            // where the path bends
  std::vector<State> states_;          // every kTick
};

}  // namespace predictive_stereo::simulation
