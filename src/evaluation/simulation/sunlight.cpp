#include "evaluation/simulation/sunlight.h"

#include <Eigen/Geometry>
#include <limits>

namespace predictive_stereo::simulation {

using Eigen::Vector3f;

Sunlight::Sunlight(const std::vector<Primitive>& primitives, const Vector3f& to_sun,
                   const Eigen::Vector3d& centre_m)
    : primitives_(&primitives),
      casters_(primitives.size()),
      tiles_({-kReach_m, -kReach_m, 2 * kReach_m, 2 * kReach_m}, 1.0f) {
  across_ = to_sun.cross(Vector3f::UnitZ()).normalized();
  up_ = across_.cross(to_sun);
  std::vector<Tiles::Item> items;
  for (size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    if (p.shape == Shape::kGround) continue;
    Caster& caster = casters_[i];
    caster.centre_m = (p.centre_m - centre_m).cast<float>();
    caster.direction = p.R_local_world * to_sun;
    // Extent of the box normal to the rays.
    const auto extent = [&](const Vector3f& axis) {
      return (p.R_local_world * axis).cwiseAbs().dot(p.half_m) + 1e-3f;
    };
    const float width = extent(across_), height = extent(up_);
    const float x = caster.centre_m.dot(across_), y = caster.centre_m.dot(up_);
    items.push_back({x - width, y - height, x + width, y + height, 0, static_cast<int>(i)});
  }
  // The largest ones first, because they are the most likely hits.
  std::stable_sort(items.begin(), items.end(), [](const Tiles::Item& a, const Tiles::Item& b) {
    return (a.right - a.left) * (a.bottom - a.top) > (b.right - b.left) * (b.bottom - b.top);
  });
  tiles_.fill(items);
}

bool Sunlight::reaches(const Vector3f& point_m) const {
  const float x = point_m.dot(across_), y = point_m.dot(up_);
  if (std::abs(x) > kReach_m || std::abs(y) > kReach_m) return true;
  for (const Tiles::Item& item : tiles_.at(x, y)) {
    if (!item.covers(x, y)) continue;
    const auto i = static_cast<size_t>(item.index);
    const Primitive& p = (*primitives_)[i];
    float t = std::numeric_limits<float>::infinity();
    int part = 0;
    if (intersect(p, p.R_local_world * (point_m - casters_[i].centre_m), casters_[i].direction,
                  2e-3f, t, part))
      return false;
  }
  return true;
}

}  // namespace predictive_stereo::simulation
