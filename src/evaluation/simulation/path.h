/// Trajectory of the body that carries the camera.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "evaluation/simulation/models.h"
#include "evaluation/simulation/scene.h"

namespace predictive_stereo::simulation {

class Path {
 public:
  virtual ~Path() = default;

  /// Pose T_world_body: x ahead, y to the left, z up.
  virtual Isometry3d bodyAt(double time_s) const = 0;

  /// Place on the ground this far ahead of the body along its path.
  virtual Place placeAhead(double time_s, double gap_m) const = 0;
  Place placeAt(double time_s) const { return placeAhead(time_s, 0); }
};

/// A trajectory through waypoints, at their times, plus shakes. Each coordinate and angle is a
/// monotone cubic interpolant (Fritsch and Carlson, 1980): values that are equal at two consecutive
/// waypoints are constant between them, and nothing overshoots.
class WaypointPath : public Path {
 public:
  /// @param waypoints  at least one; times increase.
  WaypointPath(const std::vector<Waypoint>& waypoints, const std::vector<Shake>& shakes,
               uint32_t seed);
  Isometry3d bodyAt(double time_s) const override;
  Place placeAhead(double time_s, double gap_m) const override;

 private:
  using Coordinates = Eigen::Matrix<double, 6, 1>;  // x, y, z [m]; heading, pitch, roll [rad]
  Coordinates smoothAt(double time_s) const;
  Coordinates shakeAt(double time_s) const;

  std::vector<double> times_s_;
  std::vector<Coordinates> values_, slopes_;
  std::vector<Shake> shakes_;
  uint32_t seed_;
};

/// The path of a scene, from 0 to duration_s.
std::unique_ptr<Path> makePath(const Scene& scene, double duration_s, uint32_t seed);

}  // namespace predictive_stereo::simulation
