#include "evaluation/simulation/glossy.h"

#include <cmath>
#include <cstring>

namespace predictive_stereo::simulation {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// Black, dark blue, dark metallic or silver metallic. All parts of a car get the same one, because
// their paint has the same albedo.
float glossyAlbedo(float paint) {
  constexpr float kPaints[] = {0.015f, 0.03f, 0.06f, 0.2f};
  uint32_t bits;
  std::memcpy(&bits, &paint, sizeof(bits));
  return kPaints[hashOf(bits) % 4];
}

void addInside(const Primitive& cabin, Shape shape, const Vector3d& local_m, const Vector3d& half_m,
               float albedo, Primitives& out) {
  Primitive p;
  p.shape = shape;
  p.material = Material::kCloth;
  p.object = cabin.object;
  p.seed = hashOf(cabin.seed, static_cast<uint32_t>(out.size()));
  p.albedo = albedo;
  p.centre_m = cabin.centre_m + cabin.R_local_world.transpose().cast<double>() * local_m;
  p.R_local_world = cabin.R_local_world;
  p.half_m = half_m.cast<float>();
  out.push_back(p);
}

// Adds two rows of seats with headrests, and a dashboard.
void furnish(const Primitive& cabin, Primitives& out) {
  const Vector3d half = cabin.half_m.cast<double>();
  const double belt = half.z() > 0.5 ? 0.0 : -half.z();  // cabins of vans begin at their floor
  for (const double row : {0.05, -0.5})
    for (const double side : {-0.45, 0.45}) {
      const Vector3d seat(row * half.x(), side * half.y(), belt);
      addInside(cabin, Shape::kBox, seat, {0.06, 0.21, 0.3}, 0.12f, out);
      addInside(cabin, Shape::kEllipsoid, seat + Vector3d(0, 0, 0.38), {0.06, 0.13, 0.09}, 0.2f,
                out);
    }
  addInside(cabin, Shape::kBox, {0.8 * half.x(), 0, belt}, {0.12, 0.7 * half.y(), 0.05}, 0.08f,
            out);
}

}  // namespace

void makeGlossy(Primitives& primitives) {
  const size_t count = primitives.size();
  for (size_t i = 0; i < count; ++i) {
    Primitive& p = primitives[i];
    const bool of_a_car = p.shape == Shape::kFrustum || p.shape == Shape::kEllipsoid;
    if (p.material == Material::kPaint && of_a_car) {
      p.material = Material::kGloss;
      p.albedo = glossyAlbedo(p.albedo);
    } else if (p.material == Material::kCabin) {
      p.material = Material::kGlossCabin;
      p.albedo = glossyAlbedo(p.albedo);
      furnish(Primitive(p), primitives);
    }
  }
}

float fresnel(float along_normal, float cosine) {
  return along_normal + (1 - along_normal) * std::pow(1 - cosine, 5.0f);
}

Vector3f normalOfPanel(const Primitive& primitive, const Vector3f& normal, const Vector3f& local) {
  if (primitive.shape == Shape::kEllipsoid) return normal;
  const Vector3f from_middle = local.cwiseQuotient(primitive.half_m);
  return (normal + kPanelTurn * (from_middle - normal.dot(from_middle) * normal)).normalized();
}

}  // namespace predictive_stereo::simulation
