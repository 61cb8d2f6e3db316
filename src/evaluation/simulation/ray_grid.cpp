#include "evaluation/simulation/ray_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace predictive_stereo::simulation {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kHuge = 1e9f;

// Corners of a primitive's box in the camera's frame.
std::array<Vector3d, 8> cornersOf(const Primitive& p, const Eigen::Isometry3d& T_cam_world) {
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

}  // namespace

RayGrid::RayGrid(const std::vector<Primitive>& primitives, const Eigen::Isometry3d& T_world_cam,
                 const StereoRig& rig, double cx_px)
    : primitives_(&primitives),
      origins_(primitives.size()),
      items_(primitives.size()),
      tiles_({-kMargin_px, -kMargin_px, static_cast<float>(rig.size.width) + 2 * kMargin_px,
              static_cast<float>(rig.size.height) + 2 * kMargin_px},
             kTile_px),
      R_world_cam_(T_world_cam.linear().cast<float>()),
      cx_(static_cast<float>(cx_px)),
      cy_(static_cast<float>(rig.cy_px)),
      inverse_f_(static_cast<float>(1 / rig.fx_px)),
      inverse_fy_(static_cast<float>(1 / rig.fy_px)) {
  const Eigen::Isometry3d T_cam_world = T_world_cam.inverse();
  for (size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    origins_[i] = p.R_local_world * (T_world_cam.translation() - p.centre_m).cast<float>();
    items_[i] = {-kHuge, -kHuge, kHuge, kHuge, 0, static_cast<int>(i)};
    if (p.shape == Shape::kGround) continue;
    // Bounds of the part of the box in front of the camera.
    const auto corners = cornersOf(p, T_cam_world);
    double left = kHuge, right = -kHuge, top = kHuge, bottom = -kHuge, nearest = kHuge;
    const double near = 0.5 * kNearest_m;
    const auto take = [&](const Vector3d& c) {
      const double x = rig.fx_px * c.x() / c.z() + cx_px, y = rig.fy_px * c.y() / c.z() + rig.cy_px;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
      nearest = std::min(nearest, c.z());
    };
    for (size_t a = 0; a < 8; ++a) {
      if (corners[a].z() >= near) take(corners[a]);
      for (size_t bit = 1; bit < 8; bit *= 2) {
        const size_t b = a ^ bit;
        if (a < b || (corners[a].z() >= near) == (corners[b].z() >= near)) continue;
        const double share = (near - corners[a].z()) / (corners[b].z() - corners[a].z());
        take(corners[a] + share * (corners[b] - corners[a]));
      }
    }
    // Slightly enlarged against rounding. Empty if all of the box is behind the camera.
    items_[i] = {static_cast<float>(left - 0.01),
                 static_cast<float>(top - 0.01),
                 static_cast<float>(right + 0.01),
                 static_cast<float>(bottom + 0.01),
                 static_cast<float>(nearest - 1e-3 * (1 + nearest)),
                 static_cast<int>(i)};
  }
  std::vector<Tiles::Item> sorted = items_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Tiles::Item& a, const Tiles::Item& b) {
    return a.nearest < b.nearest;
  });
  tiles_.fill(sorted);
}

cv::Rect2f RayGrid::boundsOf(int primitive) const {
  const Tiles::Item& item = items_[static_cast<size_t>(primitive)];
  if (item.right < item.left) return {};
  return {item.left, item.top, item.right - item.left, item.bottom - item.top};
}

Hit RayGrid::cast(float x_px, float y_px, float limit_m, int except) const {
  const Vector3f direction = directionOf(x_px, y_px);
  Hit hit;
  hit.t = limit_m;
  for (const Tiles::Item& item : tiles_.at(x_px, y_px)) {
    if (item.nearest >= hit.t) break;
    if (!item.covers(x_px, y_px) || item.index == except) continue;
    const auto i = static_cast<size_t>(item.index);
    const Primitive& p = (*primitives_)[i];
    if (intersect(p, origins_[i], p.R_local_world * direction, inverse_f_, hit.t, hit.part))
      hit.primitive = item.index;
  }
  return hit;
}

bool RayGrid::blocked(float x_px, float y_px, float limit_m) const {
  return !cast(x_px, y_px, limit_m).sky();
}

bool RayGrid::meets(int index, float x_px, float y_px) const {
  const Primitive& p = (*primitives_)[static_cast<size_t>(index)];
  float t = std::numeric_limits<float>::infinity();
  int part = 0;
  return intersect(p, origins_[static_cast<size_t>(index)],
                   p.R_local_world * directionOf(x_px, y_px), inverse_f_, t, part);
}

}  // namespace predictive_stereo::simulation
