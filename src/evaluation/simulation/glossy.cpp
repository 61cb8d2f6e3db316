#include "evaluation/simulation/glossy.h"

#include <cstring>

namespace predictive_stereo::simulation {
namespace {

using Eigen::Vector3d;

// Black, dark blue, dark metallic or silver metallic. All parts of a car get the same one, because
// their paint has the same albedo.
float glossyAlbedo(float paint) {
  constexpr float kPaints[] = {0.015f, 0.03f, 0.06f, 0.2f};
  uint32_t bits;
  std::memcpy(&bits, &paint, sizeof(bits));
  return kPaints[hashOf(bits) % 4];
}

// Adds two rows of seats with headrests, and a dashboard.
void furnish(const Primitive& cabin, Primitives& out) {
  Builder b(cabin.centre_m, cabin.R_local_world.transpose().cast<double>(), cabin.seed,
            cabin.object, out, static_cast<uint32_t>(out.size()));
  const Vector3d half = cabin.half_m.cast<double>();
  const double belt = half.z() > 0.5 ? 0.0 : -half.z();  // cabins of vans begin at their floor
  for (const double row : {0.05, -0.5})
    for (const double side : {-0.45, 0.45}) {
      const Vector3d seat(row * half.x(), side * half.y(), belt);
      b.box(Material::kCloth, seat, {0.06, 0.21, 0.3}, 0.12);
      b.add(Shape::kEllipsoid, Material::kCloth, seat + Vector3d(0, 0, 0.38), {0.06, 0.13, 0.09},
            0.2);
    }
  b.box(Material::kCloth, {0.8 * half.x(), 0, belt}, {0.12, 0.7 * half.y(), 0.05}, 0.08);
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

}  // namespace predictive_stereo::simulation
