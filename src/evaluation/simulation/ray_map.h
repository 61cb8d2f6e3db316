/// Spatial index of the primitives for rays from any point in any direction: lists by tile of the
/// ground.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "evaluation/simulation/primitive.h"
#include "evaluation/simulation/tiles.h"

namespace predictive_stereo::simulation {

class RayMap {
 public:
  static constexpr float kReach_m = 100;  ///< only sky is farther from the centre along x or y

  /// @param primitives  must outlive the map.
  /// @param centre_m  points are given relative to it.
  RayMap(const std::vector<Primitive>& primitives, const Eigen::Vector3d& centre_m);

  /// First hit of a ray, where primitive `except` is ignored; t is the distance along it [m].
  /// @param origin_m  relative to the centre, world axes.
  /// @param direction  unit length.
  Hit cast(const Eigen::Vector3f& origin_m, const Eigen::Vector3f& direction, int except) const;

  /// A point (relative to the centre) in the local axes of a primitive.
  Eigen::Vector3f inLocalAxes(int primitive, const Eigen::Vector3f& point_m) const {
    const auto i = static_cast<size_t>(primitive);
    return (*primitives_)[i].R_local_world * (point_m - centres_m_[i]);
  }

 private:
  void test(int primitive, const Eigen::Vector3f& origin_m, const Eigen::Vector3f& direction,
            Hit& hit) const;

  const std::vector<Primitive>* primitives_;
  std::vector<Eigen::Vector3f> centres_m_;
  std::vector<float> radii2_m2_;  // of spheres around the primitives, squared
  std::vector<int> everywhere_;   // planes
  Tiles tiles_;
};

}  // namespace predictive_stereo::simulation
