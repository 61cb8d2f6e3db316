#include "evaluation/simulation/ray_map.h"

#include <cmath>
#include <limits>

namespace predictive_stereo::simulation {
namespace {

using Eigen::Vector3f;

constexpr float kTile_m = 2.5f;
constexpr float kFinest_m = 2e-3f;  // per metre: see intersect()

}  // namespace

RayMap::RayMap(const std::vector<Primitive>& primitives, const Eigen::Vector3d& centre_m)
    : primitives_(&primitives),
      centres_m_(primitives.size()),
      radii2_m2_(primitives.size(), std::numeric_limits<float>::infinity()),
      tiles_({-kReach_m, -kReach_m, 2 * kReach_m, 2 * kReach_m}, kTile_m) {
  std::vector<Tiles::Item> items;
  for (size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    centres_m_[i] = (p.centre_m - centre_m).cast<float>();
    if (p.shape == Shape::kGround) {
      everywhere_.push_back(static_cast<int>(i));
      continue;
    }
    radii2_m2_[i] = p.half_m.squaredNorm();
    const Vector3f extent = p.R_local_world.transpose().cwiseAbs() * p.half_m;
    const float x = centres_m_[i].x(), y = centres_m_[i].y();
    items.push_back({x - extent.x() - 1e-3f, y - extent.y() - 1e-3f, x + extent.x() + 1e-3f,
                     y + extent.y() + 1e-3f, 0, static_cast<int>(i)});
  }
  tiles_.fill(items);
}

void RayMap::test(int primitive, const Vector3f& origin_m, const Vector3f& direction,
                  Hit& hit) const {
  const auto i = static_cast<size_t>(primitive);
  // Early exit: most rays miss the bounding sphere.
  const Vector3f to_centre = centres_m_[i] - origin_m;
  const float along = to_centre.dot(direction);
  if (to_centre.squaredNorm() - along * along > radii2_m2_[i]) return;
  const Primitive& p = (*primitives_)[i];
  if (intersect(p, inLocalAxes(primitive, origin_m), p.R_local_world * direction, kFinest_m, hit.t,
                hit.part))
    hit.primitive = primitive;
}

Hit RayMap::cast(const Vector3f& origin_m, const Vector3f& direction, int except) const {
  Hit hit;
  hit.t = std::numeric_limits<float>::infinity();
  for (const int plane : everywhere_)
    if (plane != except) test(plane, origin_m, direction, hit);
  // From tile to tile (Amanatides and Woo, 1987), until there is a hit inside one.
  constexpr int kTiles = static_cast<int>(2 * kReach_m / kTile_m);
  int tile[2], step[2];
  float leaves[2], per_tile[2];  // distances along the ray
  for (int axis = 0; axis < 2; ++axis) {
    tile[axis] = static_cast<int>(std::floor((origin_m[axis] + kReach_m) / kTile_m));
    step[axis] = direction[axis] > 0 ? 1 : -1;
    const auto border = static_cast<float>(tile[axis] + (direction[axis] > 0));
    leaves[axis] = (border * kTile_m - kReach_m - origin_m[axis]) / direction[axis];
    per_tile[axis] = kTile_m / std::abs(direction[axis]);
    if (direction[axis] == 0) leaves[axis] = per_tile[axis] = hit.t;
  }
  while (tile[0] >= 0 && tile[1] >= 0 && tile[0] < kTiles && tile[1] < kTiles) {
    const auto middle = [&](int axis) {
      return (static_cast<float>(tile[axis]) + 0.5f) * kTile_m - kReach_m;
    };
    for (const Tiles::Item& item : tiles_.at(middle(0), middle(1)))
      if (item.index != except) test(item.index, origin_m, direction, hit);
    const int axis = leaves[0] < leaves[1] ? 0 : 1;
    if (hit.t <= leaves[axis] || std::isinf(leaves[axis])) break;
    leaves[axis] += per_tile[axis];
    tile[axis] += step[axis];
  }
  return hit;
}

}  // namespace predictive_stereo::simulation
