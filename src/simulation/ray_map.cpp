#include "simulation/ray_map.h"

#include <cmath>
#include <limits>

namespace predictive_stereo::simulation {
namespace {

using Eigen::Vector3f;

constexpr float kTile_m = 3;
constexpr float kFinest_m = 2e-3f;  // per metre: see intersect()

}  // namespace

RayMap::RayMap(const std::vector<Primitive>& primitives, const Eigen::Vector3d& centre_m)
    : primitives_(&primitives),
      centres_m_(primitives.size()),
      tiles_({-kReach_m, -kReach_m, 2 * kReach_m, 2 * kReach_m}, kTile_m) {
  std::vector<Tiles::Item> items;
  for (size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    centres_m_[i] = (p.centre_m - centre_m).cast<float>();
    if (p.shape == Shape::kGround) {
      everywhere_.push_back(static_cast<int>(i));
      continue;
    }
    const Vector3f extent = p.R_local_world.transpose().cwiseAbs() * p.half_m;
    const float x = centres_m_[i].x(), y = centres_m_[i].y();
    items.push_back({x - extent.x() - 1e-3f, y - extent.y() - 1e-3f, x + extent.x() + 1e-3f,
                     y + extent.y() + 1e-3f, 0, static_cast<int>(i)});
  }
  tiles_.fill(items);
}

void RayMap::test(int primitive, const Vector3f& origin_m, const Vector3f& direction,
                  Hit& hit) const {
  const Primitive& p = (*primitives_)[static_cast<size_t>(primitive)];
  if (intersect(p, inLocalAxes(primitive, origin_m), p.R_local_world * direction, kFinest_m, hit.t,
                hit.part))
    hit.primitive = primitive;
}

Hit RayMap::cast(const Vector3f& origin_m, const Vector3f& direction, int except) const {
  Hit hit;
  hit.t = std::numeric_limits<float>::infinity();
  for (const int plane : everywhere_)
    if (plane != except) test(plane, origin_m, direction, hit);
  // From tile to tile, until something is met within them.
  float t = 0;
  while (true) {
    const Vector3f at = origin_m + (t + 1e-3f) * direction;
    if (std::abs(at.x()) >= kReach_m || std::abs(at.y()) >= kReach_m) return hit;
    for (const Tiles::Item& item : tiles_.at(at.x(), at.y()))
      if (item.index != except) test(item.index, origin_m, direction, hit);
    float leaves = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 2; ++axis) {
      if (direction[axis] == 0) continue;
      const float tile = std::floor((at[axis] + kReach_m) / kTile_m) + (direction[axis] > 0);
      leaves = std::min(leaves, (tile * kTile_m - kReach_m - origin_m[axis]) / direction[axis]);
    }
    t = std::max(leaves, t + 1e-3f);
    if (hit.t <= t || std::isinf(t)) return hit;
  }
}

}  // namespace predictive_stereo::simulation
