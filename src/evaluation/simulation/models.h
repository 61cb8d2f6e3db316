/// Things built from primitives: vehicles, people, plants and buildings.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "evaluation/simulation/noise.h"
#include "evaluation/simulation/primitive.h"

namespace predictive_stereo::simulation {

constexpr double kPi = 3.14159265358979;

using Primitives = std::vector<Primitive>;

/// Pose of a thing: its point on the ground, and its heading (0: along the world's x).
struct Place {
  Vector3d position_m = Vector3d::Zero();
  double heading_rad = 0;

  Vector2d ahead() const { return {std::cos(heading_rad), std::sin(heading_rad)}; }
};

/// Adds primitives given in the axes of a thing: x ahead, y left, z up.
class Builder {
 public:
  /// @param first  number of the first primitive: each one's seed is made of `seed` and its number.
  Builder(const Place& place, uint32_t seed, int object, Primitives& out, uint32_t first = 1)
      : position_m_(place.position_m),
        R_world_thing_(Eigen::AngleAxisd(place.heading_rad, Vector3d::UnitZ()).toRotationMatrix()),
        object_(object),
        seed_(seed),
        next_(first),
        out_(out) {}

  Primitive& add(Shape shape, Material material, const Vector3d& centre, const Vector3d& half,
                 double albedo,
                 const Eigen::Matrix3d& R_thing_local = Eigen::Matrix3d::Identity()) {
    Primitive p;
    p.shape = shape;
    p.material = material;
    p.object = object_;
    p.seed = hashOf(seed_, next_++);
    p.albedo = static_cast<float>(albedo);
    p.centre_m = position_m_ + R_world_thing_ * centre;
    p.R_local_world = (R_world_thing_ * R_thing_local).transpose().cast<float>();
    p.half_m = half.cast<float>();
    out_.push_back(p);
    return out_.back();
  }

  Primitive& box(Material material, const Vector3d& centre, const Vector3d& half, double albedo) {
    return add(Shape::kBox, material, centre, half, albedo);
  }

  Primitive& ellipsoid(Material material, const Vector3d& centre, const Vector3d& half,
                       double albedo) {
    return add(Shape::kEllipsoid, material, centre, half, albedo);
  }

  /// A rod between two points.
  void rod(Material material, const Vector3d& from, const Vector3d& to, double radius,
           double albedo) {
    const Vector3d axis = to - from;
    add(Shape::kCylinder, material, 0.5 * (from + to), {radius, radius, 0.5 * axis.norm()}, albedo,
        Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), axis).toRotationMatrix());
  }

  /// See Primitive for the measures of its top.
  void frustum(Material material, const Vector3d& centre, const Vector3d& half, double top_back,
               double top_front, double top_side, double albedo) {
    Primitive& p = add(Shape::kFrustum, material, centre, half, albedo);
    p.top_back_m = static_cast<float>(top_back);
    p.top_front_m = static_cast<float>(top_front);
    p.top_side_m = static_cast<float>(top_side);
  }

 private:
  Vector3d position_m_;
  Eigen::Matrix3d R_world_thing_;
  int object_;
  uint32_t seed_, next_;
  Primitives& out_;
};

enum class Kind : uint8_t { kCar, kVan, kTruck, kBus, kPerson, kCyclist };
constexpr const char* kKindNames[] = {"car", "van", "truck", "bus", "person", "cyclist"};

/// Length, width and height [m] of the model of this kind and seed.
Vector3d sizeOf(Kind kind, uint32_t seed);

/// Adds a model. `stride_m` is the distance it has moved: legs and arms swing with it.
void addThing(Kind kind, uint32_t seed, const Place& place, double stride_m, int object,
              Primitives& out);

void addTree(const Place& place, uint32_t seed, Primitives& out);
void addBush(const Place& place, double length_m, double height_m, uint32_t seed, Primitives& out);
void addLampPost(const Place& place, Primitives& out);
void addSignPost(const Place& place, uint32_t seed, Primitives& out);
void addFence(const Place& place, double length_m, uint32_t seed, Primitives& out);
/// A house whose front, `width_m` long, faces along the place's heading.
void addHouse(const Place& place, double width_m, double depth_m, uint32_t seed, Primitives& out);

}  // namespace predictive_stereo::simulation
