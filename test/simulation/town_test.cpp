#include <gtest/gtest.h>

#include <algorithm>

#include "evaluation/simulation/worlds.h"

namespace predictive_stereo::simulation {
namespace {

// Ahead, 80 degrees wide.
View viewFrom(double x_m, double y_m) { return {{x_m, y_m, 1.5}, {1, 0}, 0.84}; }

Primitives townIn(const View& view) {
  Primitives town;
  addTown(Scene(), 1, view, town);
  return town;
}

bool isSame(const Primitive& a, const Primitive& b) {
  return a.centre_m == b.centre_m && a.half_m == b.half_m && a.shape == b.shape &&
         a.material == b.material && a.albedo == b.albedo;
}

// A car that is parked in one frame is parked in all frames: the world stands still.
TEST(Town, IsTheSameFromEverywhere) {
  constexpr double kNear_m = 100;  // distant houses have no details
  const View first = viewFrom(0, -1.5);
  const Primitives town = townIn(first);
  int compared = 0;
  for (const double x_m : {4.0, 45.0, 60.0}) {
    const View later = viewFrom(x_m, -1.5);
    const Primitives other = townIn(later);
    const auto expectPartOf = [&](const Primitives& all, const Primitives& part) {
      for (const Primitive& primitive : part) {
        const Eigen::Vector2d at = primitive.centre_m.head<2>();
        if (primitive.shape == Shape::kGround || !first.reaches(at, 0) || !later.reaches(at, 0) ||
            std::max(first.distance(at), later.distance(at)) > kNear_m)
          continue;
        ++compared;
        EXPECT_TRUE(
            std::any_of(all.begin(), all.end(),
                        [&](const Primitive& candidate) { return isSame(primitive, candidate); }))
            << "at " << at.transpose() << ", seen from " << x_m;
      }
    };
    expectPartOf(town, other);
    expectPartOf(other, town);
  }
  EXPECT_GT(compared, 1000);
}

}  // namespace
}  // namespace predictive_stereo::simulation
