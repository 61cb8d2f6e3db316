/// Shadows.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "simulation/primitive.h"
#include "simulation/tiles.h"

namespace predictive_stereo::simulation {

/// All primitives as the sun sees them: parallel rays, tiles of a plane across them.
class Sunlight {
 public:
  static constexpr float kReach_m = 110;  ///< farther from the centre there are no shadows

  /// @param primitives  must outlive the sunlight.
  /// @param centre_m  points are given relative to it.
  Sunlight(const std::vector<Primitive>& primitives, const Eigen::Vector3f& to_sun,
           const Eigen::Vector3d& centre_m);

  /// Does the sun shine on this point (world axes, relative to the centre)? What lies within
  /// kNearest_m of it casts no shadow.
  bool reaches(const Eigen::Vector3f& point_m) const;

 private:
  struct Caster {
    Eigen::Vector3f centre_m, direction;  // the latter in local axes
  };
  const std::vector<Primitive>* primitives_;
  std::vector<Caster> casters_;
  Tiles tiles_;
  Eigen::Vector3f across_, up_;
};

}  // namespace predictive_stereo::simulation
