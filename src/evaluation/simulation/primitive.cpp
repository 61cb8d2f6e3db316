#include "evaluation/simulation/primitive.h"

#include <algorithm>
#include <cmath>

#include "evaluation/simulation/noise.h"

namespace predictive_stereo::simulation {
namespace {

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
  if (face == 0) return {-height, 0, p.top_back_m + p.half_m.x()};
  if (face == 1) return {height, 0, p.half_m.x() - p.top_front_m};
  return {0, face == 2 ? -height : height, p.half_m.y() - p.top_side_m};
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

// Replaces the entry through a wall by that into a pane, or of a side of its recess, if there is a
// window.
void fallIntoWindow(const Primitive& p, const Vector3f& o, const Vector3f& d, Stretch& stretch) {
  const Windows& w = p.windows;
  const int wall = stretch.face, across = wall / 2, along = 1 - across;
  const Vector3f met = o + stretch.enter * d;
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
  stretch.enter += std::min(to_pane, to_side);
  stretch.face = (to_pane < to_side ? kPane : kReveal) + wall;
}

bool clipCylinder(const Primitive& p, const Vector3f& o, const Vector3f& d, Stretch& stretch) {
  const float a = d.x() * d.x() + d.y() * d.y();
  const float b = o.x() * d.x() + o.y() * d.y();
  const float radius2 = p.half_m.x() * p.half_m.x();
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
  return stretch.clip(-o.z() - p.half_m.z(), -d.z(), 4) &&
         stretch.clip(o.z() - p.half_m.z(), d.z(), 5);
}

bool clipEllipsoid(const Vector3f& half, const Vector3f& o, const Vector3f& d, Stretch& stretch) {
  const Vector3f unit_o = o.cwiseQuotient(half), unit_d = d.cwiseQuotient(half);
  const float a = unit_d.squaredNorm();
  const float middle = -unit_o.dot(unit_d) / a;
  const float rest = 1 - (unit_o + middle * unit_d).squaredNorm();
  if (rest <= 0) return false;
  stretch.enter = middle - std::sqrt(rest / a);
  return true;
}

bool isPlate(Shape shape) {
  return shape == Shape::kLeaves || shape == Shape::kRing || shape == Shape::kBars;
}

// Whether a plate has a hole at this point, or ends before it.
// @param finest_m  leaves are enlarged to this size, which pixels can show.
bool isHole(const Primitive& p, float x, float z, float finest_m) {
  if (p.shape == Shape::kLeaves) {
    const float u = x / p.half_m.x(), v = z / p.half_m.z();
    const float radius2 = u * u + v * v;
    const float size_m = std::max(0.07f, finest_m);  // sparser towards the rim
    return radius2 > 1 || noise2(x / size_m, z / size_m, p.seed) < 0.75f * radius2 - 0.35f;
  }
  if (p.shape == Shape::kRing) {
    const float radius2 = x * x + z * z, outer = p.half_m.x(), inner = 0.88f * outer;
    if (radius2 > outer * outer) return true;
    if (radius2 >= inner * inner || radius2 <= 0.01f * outer * outer) return false;
    // Between rim and hub there are spokes: six narrow sectors.
    const float angle = std::atan2(z, x) * (6 / 3.14159265f);
    return std::abs(angle - std::round(angle)) * std::sqrt(radius2) > 0.02f;
  }
  if (std::abs(x) > p.half_m.x() || std::abs(z) > p.half_m.z()) return true;
  const bool rail = std::abs(z) > 0.92f * p.half_m.z();
  return !rail && std::abs(withinCell(x + p.half_m.x(), 0.14f)) > 0.022f;
}

Surface flat(const Vector3f& normal, const Vector3f& u, const Vector3f& v, const Vector3f& point) {
  return {normal, u, v, point.dot(u), point.dot(v)};
}

Surface curved(const Vector3f& normal, float u_m, float v_m) {
  return {normal, Vector3f::Zero(), Vector3f::Zero(), u_m, v_m};
}

}  // namespace

bool intersect(const Primitive& p, const Vector3f& o, const Vector3f& d, float pixel_per_m,
               Hit& hit) {
  Stretch stretch;
  const auto clip = [&] {
    switch (p.shape) {
      case Shape::kGround:
        return stretch.clip(o.z(), d.z(), 5);
      case Shape::kBox:
      case Shape::kBuilding:
        return clipBox(p.half_m, o, d, stretch);
      case Shape::kFrustum:
        return clipFrustum(p, o, d, stretch);
      case Shape::kCylinder:
        return clipCylinder(p, o, d, stretch);
      case Shape::kEllipsoid:
        return clipEllipsoid(p.half_m, o, d, stretch);
      default:  // plates
        stretch.enter = -o.y() / d.y();
        return d.y() != 0;
    }
  };
  // A solid is invisible from inside, because its near half is behind the camera.
  if (!clip() || stretch.enter < kNearest_m || stretch.enter >= hit.t) return false;
  if (p.shape == Shape::kBuilding && stretch.face < 4 && p.windows.cell_width_m > 0) {
    fallIntoWindow(p, o, d, stretch);
    if (stretch.enter >= hit.t) return false;
  }
  if (isPlate(p.shape) && isHole(p, o.x() + stretch.enter * d.x(), o.z() + stretch.enter * d.z(),
                                 2.2f * pixel_per_m * stretch.enter))
    return false;
  hit.t = stretch.enter;
  hit.part = stretch.face;
  return true;
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
      return flat(normal, face < 2 ? y : x, face < 4 ? z : y, point);
    }
    case Shape::kCylinder: {
      if (part == 4 || part == 5) return flat(part == 5 ? z : Vector3f(-z), x, y, point);
      const Vector3f normal = Vector3f(point.x(), point.y(), 0) / p.half_m.x();
      return curved(normal, std::atan2(point.y(), point.x()) * p.half_m.x(), point.z());
    }
    case Shape::kEllipsoid:
      return curved(point.cwiseQuotient(p.half_m.cwiseProduct(p.half_m)).normalized(), point.x(),
                    point.z());
    default:  // plates
      return flat(y, x, z, point);
  }
}

}  // namespace predictive_stereo::simulation
