/// Shadows of the sun.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "evaluation/simulation/primitive.h"
#include "evaluation/simulation/tiles.h"

namespace predictive_stereo::simulation {

/// Spatial index of the primitives for rays to the sun, which are parallel: lists by tile of a
/// plane normal to them.
class Sunlight {
 public:
  static constexpr float kReach_m = 110;  ///< no shadows farther from the centre

  /// @param primitives  must outlive the sunlight.
  /// @param centre_m  points are given relative to it.
  Sunlight(const std::vector<Primitive>& primitives, const Eigen::Vector3f& to_sun,
           const Eigen::Vector3d& centre_m);

  /// Whether the sun shines on this point (world axes, relative to the centre). Surfaces within
  /// kNearest_m of it cast no shadow.
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
