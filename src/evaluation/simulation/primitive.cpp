#include "evaluation/simulation/primitive.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "evaluation/simulation/noise.h"

namespace predictive_stereo::simulation {
namespace {

using Eigen::Vector3f;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Interval of a ray inside a convex solid, clipped by one face after the other.
struct Stretch {
  float enter = -kInfinity, leave = kInfinity;
  int face = 0;  // where it enters

  // Keeps the part with distance + t * slope <= 0.
  bool clip(float distance, float slope, int index) {
    if (slope == 0) return distance <= 0;
    const float t = -distance / slope;
    if (slope < 0) {
      if (t > enter) {
        enter = t;
        face = index;
      }
    } else {
      leave = std::min(leave, t);
    }
    return enter <= leave;
  }
};

bool updateHit(const Stretch& stretch, float& t, int& part) {
  // A solid is invisible from inside, because its near half is behind the camera.
  if (stretch.enter < kNearest_m || stretch.enter >= t) return false;
  t = stretch.enter;
  part = stretch.face;
  return true;
}

bool clipBox(const Vector3f& half, const Vector3f& o, const Vector3f& d, Stretch& stretch) {
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0) {
      if (std::abs(o[axis]) > half[axis]) return false;
      continue;
    }
    const float inverse = 1 / d[axis], middle = -o[axis] * inverse;
    const float reach = half[axis] * std::abs(inverse);
    if (middle - reach > stretch.enter) {
      stretch.enter = middle - reach;
      stretch.face = 2 * axis + (d[axis] < 0);
    }
    stretch.leave = std::min(stretch.leave, middle + reach);
    if (stretch.enter > stretch.leave) return false;
  }
  return true;
}

// Normals (not of unit length) of a frustum's inclined faces.
Vector3f inclinedNormal(const Primitive& p, int face) {
  const float height = 2 * p.half_m.z();
  switch (face) {
    case 0:
      return {-height, 0, p.top_back_m + p.half_m.x()};
    case 1:
      return {height, 0, p.half_m.x() - p.top_front_m};
    case 2:
      return {0, -height, p.half_m.y() - p.top_side_m};
    default:
      return {0, height, p.half_m.y() - p.top_side_m};
  }
}

bool clipFrustum(const Primitive& p, const Vector3f& o, const Vector3f& d, Stretch& stretch) {
  const Vector3f& h = p.half_m;
  if (!stretch.clip(-o.z() - h.z(), -d.z(), 4) || !stretch.clip(o.z() - h.z(), d.z(), 5))
    return false;
  for (int face = 0; face < 4; ++face) {
    const Vector3f normal = inclinedNormal(p, face);
    const float reach = face < 2 ? h.x() : h.y();  // of the foot, where z = -h.z
    const float distance = normal.dot(o + Vector3f(0, 0, h.z())) - 2 * h.z() * reach;
    if (!stretch.clip(distance, normal.dot(d), face)) return false;
  }
  return true;
}

// Offset from the middle of a cell.
inline float withinCell(float position, float cell) {
  return position - cell * (std::floor(position / cell) + 0.5f);
}

// Replaces the hit of a wall at t by that of a pane, or of a side of its recess, if there is a
// window.
void fallIntoWindow(const Primitive& p, const Vector3f& o, const Vector3f& d, float& t, int& part) {
  const Windows& w = p.windows;
  const int wall = part, across = wall / 2, along = 1 - across;
  const Vector3f met = o + t * d;
  const float u = withinCell(met[along] + p.half_m[along], w.cell_width_m);
  const float v = withinCell(met.z() + p.half_m.z(), w.cell_height_m);
  if (std::abs(u) >= 0.5f * w.width_m || std::abs(v) >= 0.5f * w.height_m) return;
  // No windows at the corners of the building, where cells are incomplete.
  const float to_corner = p.half_m[along] - std::abs(met[along] - u);
  if (to_corner < 0.45f * w.cell_width_m || p.half_m.z() - (met.z() - v) < 0.45f * w.cell_height_m)
    return;
  const auto until = [](float position, float half, float slope) {
    if (slope == 0) return kInfinity;
    return ((slope > 0 ? half : -half) - position) / slope;
  };
  const float to_pane = w.recess_m / std::abs(d[across]);
  const float to_side =
      std::min(until(u, 0.5f * w.width_m, d[along]), until(v, 0.5f * w.height_m, d.z()));
  t += std::min(to_pane, to_side);
  part = (to_pane < to_side ? kPane : kReveal) + wall;
}

bool meetsCylinder(const Primitive& p, const Vector3f& o, const Vector3f& d, float& t, int& part) {
  const float a = d.x() * d.x() + d.y() * d.y();
  const float b = o.x() * d.x() + o.y() * d.y();
  const float radius2 = p.half_m.x() * p.half_m.x();
  Stretch stretch;
  if (a > 0) {
    // From the closest approach: b^2 - a c would lose all digits for distant poles.
    const float middle = -b / a;
    const float x = o.x() + middle * d.x(), y = o.y() + middle * d.y();
    const float rest = radius2 - x * x - y * y;
    if (rest <= 0) return false;
    const float reach = std::sqrt(rest / a);
    stretch.enter = middle - reach;
    stretch.leave = middle + reach;
  } else if (o.x() * o.x() + o.y() * o.y() > radius2) {
    return false;
  }
  if (!stretch.clip(-o.z() - p.half_m.z(), -d.z(), 4) ||
      !stretch.clip(o.z() - p.half_m.z(), d.z(), 5))
    return false;
  return updateHit(stretch, t, part);
}

bool meetsEllipsoid(const Primitive& p, const Vector3f& o, const Vector3f& d, float& t) {
  const Vector3f unit_o = o.cwiseQuotient(p.half_m), unit_d = d.cwiseQuotient(p.half_m);
  const float a = unit_d.squaredNorm();
  const float middle = -unit_o.dot(unit_d) / a;
  const float rest = 1 - (unit_o + middle * unit_d).squaredNorm();
  if (rest <= 0) return false;
  const float met = middle - std::sqrt(rest / a);
  if (met < kNearest_m || met >= t) return false;
  t = met;
  return true;
}

bool meetsPlate(const Primitive& p, const Vector3f& o, const Vector3f& d, float pixel_per_m,
                float& t) {
  if (d.y() == 0) return false;
  const float met = -o.y() / d.y();
  if (met < kNearest_m || met >= t) return false;
  const float x = o.x() + met * d.x(), z = o.z() + met * d.z();
  if (p.shape == Shape::kLeaves) {
    const float u = x / p.half_m.x(), v = z / p.half_m.z();
    const float radius2 = u * u + v * v;
    if (radius2 > 1) return false;
    // Leaves of 7 cm, sparser towards the rim. They are enlarged if pixels are too large for them.
    const float size_m = std::max(0.07f, 2.2f * pixel_per_m * met);
    if (noise2(x / size_m, z / size_m, p.seed) < 0.75f * radius2 - 0.35f) return false;
  } else if (p.shape == Shape::kRing) {
    const float radius2 = x * x + z * z, outer = p.half_m.x(), inner = 0.88f * outer;
    if (radius2 > outer * outer) return false;
    // Spokes: six narrow sectors; a hub.
    if (radius2 < inner * inner && radius2 > 0.01f * outer * outer) {
      const float angle = std::atan2(z, x) * (6 / 3.14159265f);
      if (std::abs(angle - std::round(angle)) * std::sqrt(radius2) > 0.02f) return false;
    }
  } else {
    if (std::abs(x) > p.half_m.x() || std::abs(z) > p.half_m.z()) return false;
    const bool rail = std::abs(z) > 0.92f * p.half_m.z();
    if (!rail && std::abs(withinCell(x + p.half_m.x(), 0.14f)) > 0.022f) return false;
  }
  t = met;
  return true;
}

Surface flat(const Vector3f& normal, const Vector3f& u, const Vector3f& v, const Vector3f& point) {
  return {normal, u, v, point.dot(u), point.dot(v)};
}

}  // namespace

bool intersect(const Primitive& p, const Vector3f& o, const Vector3f& d, float pixel_per_m,
               float& t, int& part) {
  switch (p.shape) {
    case Shape::kGround: {
      if (d.z() >= 0) return false;
      const float met = -o.z() / d.z();
      if (met < kNearest_m || met >= t) return false;
      t = met;
      part = 5;
      return true;
    }
    case Shape::kBox: {
      Stretch stretch;
      return clipBox(p.half_m, o, d, stretch) && updateHit(stretch, t, part);
    }
    case Shape::kFrustum: {
      Stretch stretch;
      return clipFrustum(p, o, d, stretch) && updateHit(stretch, t, part);
    }
    case Shape::kBuilding: {
      Stretch stretch;
      float met = t;
      int face = 0;
      if (!clipBox(p.half_m, o, d, stretch) || !updateHit(stretch, met, face)) return false;
      if (face < 4 && p.windows.cell_width_m > 0) fallIntoWindow(p, o, d, met, face);
      if (met >= t) return false;
      t = met;
      part = face;
      return true;
    }
    case Shape::kCylinder:
      return meetsCylinder(p, o, d, t, part);
    case Shape::kEllipsoid:
      if (!meetsEllipsoid(p, o, d, t)) return false;
      part = 0;
      return true;
    case Shape::kLeaves:
    case Shape::kRing:
    case Shape::kBars:
      if (!meetsPlate(p, o, d, pixel_per_m, t)) return false;
      part = 0;
      return true;
  }
  return false;
}

Surface surfaceAt(const Primitive& p, int part, const Vector3f& point) {
  const Vector3f x = Vector3f::UnitX(), y = Vector3f::UnitY(), z = Vector3f::UnitZ();
  switch (p.shape) {
    case Shape::kGround:
      return flat(z, x, y, point);
    case Shape::kBox:
    case Shape::kBuilding:
    case Shape::kFrustum: {
      int face = part;
      if (part >= kReveal) {
        // The side that faces the middle of the window: vertical or horizontal, the nearer one.
        const int wall = part - kReveal, along = wall < 2 ? 1 : 0;
        const float u = withinCell(point[along] + p.half_m[along], p.windows.cell_width_m);
        const float v = withinCell(point.z() + p.half_m.z(), p.windows.cell_height_m);
        if (std::abs(u) / p.windows.width_m > std::abs(v) / p.windows.height_m)
          face = 2 * along + (u < 0 ? 1 : 0);
        else
          face = v < 0 ? 5 : 4;
      } else if (part >= kPane) {
        face = part - kPane;
      }
      Vector3f normal = Vector3f::Zero();
      normal[face / 2] = face % 2 ? 1 : -1;
      if (p.shape == Shape::kFrustum && face < 4) normal = inclinedNormal(p, face).normalized();
      if (face < 2) return flat(normal, y, z, point);
      if (face < 4) return flat(normal, x, z, point);
      return flat(normal, x, y, point);
    }
    case Shape::kCylinder: {
      if (part == 4 || part == 5) return flat(part == 5 ? z : Vector3f(-z), x, y, point);
      Surface surface;
      surface.normal = Vector3f(point.x(), point.y(), 0) / p.half_m.x();
      surface.axis_u = surface.axis_v = Vector3f::Zero();
      surface.u_m = std::atan2(point.y(), point.x()) * p.half_m.x();
      surface.v_m = point.z();
      return surface;
    }
    case Shape::kEllipsoid: {
      Surface surface;
      surface.normal = point.cwiseQuotient(p.half_m.cwiseProduct(p.half_m)).normalized();
      surface.axis_u = surface.axis_v = Vector3f::Zero();
      surface.u_m = point.x();
      surface.v_m = point.z();
      return surface;
    }
    case Shape::kLeaves:
    case Shape::kRing:
    case Shape::kBars:
      return flat(y, x, z, point);
  }
  return {};
}

}  // namespace predictive_stereo::simulation
