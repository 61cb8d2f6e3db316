#include "evaluation/simulation/rays.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace predictive_stereo::simulation {
namespace {

constexpr float kHuge = 1e9f;
constexpr float kFinest_m = 2e-3f;  // per metre: see intersect()

// Corners of a primitive's box in the camera's frame.
std::array<Vector3d, 8> cornersOf(const Primitive& p, const Isometry3d& T_cam_world) {
  const Eigen::Matrix3d R_world_local = p.R_local_world.transpose().cast<double>();
  const Vector3d half = p.half_m.cast<double>();
  std::array<Vector3d, 8> corners;
  for (int i = 0; i < 8; ++i) {
    const Vector3d local(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(),
                         i & 4 ? half.z() : -half.z());
    corners[static_cast<size_t>(i)] = T_cam_world * (p.centre_m + R_world_local * local);
  }
  return corners;
}

// A square about the origin.
Eigen::AlignedBox2f square(float half) { return {Vector2f(-half, -half), Vector2f(half, half)}; }

}  // namespace

Tiles::Tiles(const Eigen::AlignedBox2f& area, float tile_size)
    : area_(area),
      per_tile_(1 / tile_size),
      columns_(static_cast<size_t>(std::ceil(area.sizes().x() / tile_size))),
      rows_(static_cast<size_t>(std::ceil(area.sizes().y() / tile_size))),
      lists_(columns_ * rows_) {}

size_t Tiles::tileOf(float offset, size_t count) const {
  const float tile = std::max(0.0f, offset * per_tile_);
  return tile >= static_cast<float>(count) ? count - 1 : static_cast<size_t>(tile);
}

void Tiles::add(const std::vector<Item>& items) {
  for (const Item& item : items) {
    if (!area_.intersects(item.bounds)) continue;
    const Vector2f first = item.bounds.min() - area_.min(), last = item.bounds.max() - area_.min();
    const size_t last_column = tileOf(last.x(), columns_), last_row = tileOf(last.y(), rows_);
    for (size_t row = tileOf(first.y(), rows_); row <= last_row; ++row)
      for (size_t column = tileOf(first.x(), columns_); column <= last_column; ++column)
        lists_[row * columns_ + column].push_back(item);
  }
}

RayGrid::RayGrid(const std::vector<Primitive>& primitives, const Isometry3d& T_world_cam,
                 const StereoRig& rig, double cx_px)
    : primitives_(primitives),
      origins_(primitives.size()),
      items_(primitives.size()),
      tiles_({Vector2f(-kMargin_px, -kMargin_px),
              Vector2f(rig.size.width + kMargin_px, rig.size.height + kMargin_px)},
             kTile_px),
      centre_m_(T_world_cam.translation()),
      R_world_cam_(T_world_cam.linear().cast<float>()),
      cx_(static_cast<float>(cx_px)),
      cy_(static_cast<float>(rig.cy_px)),
      inverse_f_(static_cast<float>(1 / rig.fx_px)),
      inverse_fy_(static_cast<float>(1 / rig.fy_px)) {
  const Isometry3d T_cam_world = T_world_cam.inverse();
  for (size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    origins_[i] = p.R_local_world * (centre_m_ - p.centre_m).cast<float>();
    items_[i] = {{}, 0, static_cast<int>(i)};
    if (p.shape == Shape::kGround) {
      items_[i].bounds = square(kHuge);
      continue;
    }
    // Bounds of the part of the box in front of the camera.
    Eigen::AlignedBox2d bounds;
    double nearest = kHuge;
    const double near = 0.5 * kNearest_m;
    const auto take = [&](const Vector3d& c) {
      const double x = rig.fx_px * c.x() / c.z() + cx_px, y = rig.fy_px * c.y() / c.z() + rig.cy_px;
      bounds.extend(Vector2d(x, y));
      nearest = std::min(nearest, c.z());
    };
    const auto corners = cornersOf(p, T_cam_world);
    for (size_t a = 0; a < 8; ++a) {
      if (corners[a].z() >= near) take(corners[a]);
      for (size_t bit = 1; bit < 8; bit *= 2) {
        const size_t b = a ^ bit;
        if (a < b || (corners[a].z() >= near) == (corners[b].z() >= near)) continue;
        const double share = (near - corners[a].z()) / (corners[b].z() - corners[a].z());
        take(corners[a] + share * (corners[b] - corners[a]));
      }
    }
    if (bounds.isEmpty()) continue;  // behind the camera
    // Slightly enlarged against rounding.
    const Vector2d margin(0.01, 0.01);
    items_[i].bounds = {(bounds.min() - margin).cast<float>(),
                        (bounds.max() + margin).cast<float>()};
    items_[i].nearest = static_cast<float>(nearest - 1e-3 * (1 + nearest));
  }
  std::vector<Tiles::Item> sorted = items_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Tiles::Item& a, const Tiles::Item& b) {
    return a.nearest < b.nearest;
  });
  tiles_.add(sorted);
}

Hit RayGrid::cast(float x_px, float y_px) const {
  const Vector3f direction = directionOf(x_px, y_px);
  Hit hit;
  for (const Tiles::Item& item : tiles_.at(x_px, y_px)) {
    if (item.nearest >= hit.t) break;
    if (!item.bounds.contains(Vector2f(x_px, y_px))) continue;
    const auto i = static_cast<size_t>(item.index);
    const Primitive& p = primitives_[i];
    if (intersect(p, origins_[i], p.R_local_world * direction, inverse_f_, hit))
      hit.primitive = item.index;
  }
  return hit;
}

bool RayGrid::meets(int index, float x_px, float y_px) const {
  Hit hit;
  return intersect(primitive(index), originIn(index),
                   primitive(index).R_local_world * directionOf(x_px, y_px), inverse_f_, hit);
}

Shadows::Shadows(const std::vector<Primitive>& primitives, const Vector3f& to_sun,
                 const Vector3d& centre_m)
    : primitives_(primitives),
      centre_m_(centre_m),
      to_sun_(to_sun),
      across_(to_sun.cross(Vector3f::UnitZ()).normalized()),
      up_(across_.cross(to_sun)),
      tiles_(square(kReach_m), 1.0f) {
  std::vector<Tiles::Item> casters;
  for (const Primitive& p : primitives) {
    const auto index = static_cast<int>(centres_m_.size());
    const Vector3f centre = centres_m_.emplace_back((p.centre_m - centre_m).cast<float>());
    if (p.shape == Shape::kGround) continue;
    const auto extentAlong = [&](const Vector3f& axis) {
      return (p.R_local_world * axis).cwiseAbs().dot(p.half_m);
    };
    const Vector2f middle(centre.dot(across_), centre.dot(up_));
    const Vector2f half(extentAlong(across_), extentAlong(up_));
    const Vector2f enlarged = half + Vector2f(1e-3f, 1e-3f);
    casters.push_back({{middle - enlarged, middle + enlarged}, 0, index});
  }
  // The largest ones first, because they are the most likely hits.
  std::stable_sort(casters.begin(), casters.end(), [](const Tiles::Item& a, const Tiles::Item& b) {
    return a.bounds.volume() > b.bounds.volume();
  });
  tiles_.add(casters);
}

bool Shadows::sunReaches(const Vector3f& point_m) const {
  const float x = point_m.dot(across_), y = point_m.dot(up_);
  if (std::abs(x) > kReach_m || std::abs(y) > kReach_m) return true;
  const auto& casters = tiles_.at(x, y);
  return std::none_of(casters.begin(), casters.end(), [&](const Tiles::Item& item) {
    Hit hit;
    const auto i = static_cast<size_t>(item.index);
    const Primitive& p = primitives_[i];
    return item.bounds.contains(Vector2f(x, y)) &&
           intersect(p, p.R_local_world * (point_m - centres_m_[i]), p.R_local_world * to_sun_,
                     kFinest_m, hit);
  });
}

}  // namespace predictive_stereo::simulation
