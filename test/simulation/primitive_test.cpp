#include "evaluation/simulation/primitive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "evaluation/simulation/noise.h"

namespace predictive_stereo::simulation {
namespace {

using Eigen::Vector3f;

Primitive solid(Shape shape) {
  Primitive p;
  p.shape = shape;
  p.half_m = {1.2f, shape == Shape::kCylinder ? 1.2f : 0.7f, 0.9f};
  p.top_back_m = -0.8f;
  p.top_front_m = 0.3f;
  p.top_side_m = 0.5f;
  return p;
}

// The solid as a set of points.
bool contains(const Primitive& p, const Vector3f& q) {
  const Vector3f& h = p.half_m;
  if (p.shape == Shape::kEllipsoid) return q.cwiseQuotient(h).squaredNorm() <= 1;
  if (std::abs(q.z()) > h.z()) return false;
  if (p.shape == Shape::kCylinder) return q.x() * q.x() + q.y() * q.y() <= h.x() * h.x();
  if (p.shape == Shape::kBox) return std::abs(q.x()) <= h.x() && std::abs(q.y()) <= h.y();
  const float rise = (q.z() + h.z()) / (2 * h.z());
  const float front = h.x() + rise * (p.top_front_m - h.x());
  const float back = -h.x() + rise * (p.top_back_m + h.x());
  const float side = h.y() + rise * (p.top_side_m - h.y());
  return q.x() <= front && q.x() >= back && std::abs(q.y()) <= side;
}

class Solids : public testing::TestWithParam<Shape> {};

TEST_P(Solids, AreMetWhereTheRayEntersThem) {
  const Primitive p = solid(GetParam());
  Random random(5);
  int met = 0, grazed = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto within = [&](double size) {
      return Vector3f(static_cast<float>(random.uniform(-size, size)),
                      static_cast<float>(random.uniform(-size, size)),
                      static_cast<float>(random.uniform(-size, size)));
    };
    const Vector3f origin = within(1).normalized() * 6, direction = (within(1.3) - origin) / 5;
    float expected = std::numeric_limits<float>::infinity();
    constexpr float kStep = 0.001f;
    for (float t = 0; t < 10; t += kStep)
      if (contains(p, origin + t * direction)) {
        expected = t;
        break;
      }
    Hit met_at;
    const bool hit = intersect(p, origin, direction, 1e-3f, met_at);
    const float t = met_at.t;
    if (!hit || std::isinf(expected)) {
      // Ray marching misses only corners that the ray grazes for less than a step.
      ASSERT_TRUE(std::isinf(expected)) << "ray " << i;
      grazed += hit;
      continue;
    }
    ++met;
    ASSERT_NEAR(t, expected, 2 * kStep) << "ray " << i;
    const Surface surface = surfaceAt(p, met_at.part, origin + t * direction);
    ASSERT_NEAR(surface.normal.norm(), 1, 1e-4);
    ASSERT_LT(surface.normal.dot(direction), 1e-4) << "the normal points outwards, ray " << i;
    // Just outside along the normal there is nothing.
    ASSERT_FALSE(contains(p, origin + t * direction + 2e-3f * surface.normal)) << "ray " << i;
  }
  EXPECT_GT(met, 500);
  EXPECT_LT(grazed, met / 100);
}

INSTANTIATE_TEST_SUITE_P(All, Solids,
                         testing::Values(Shape::kBox, Shape::kFrustum, Shape::kCylinder,
                                         Shape::kEllipsoid));

Primitive wallWithWindows() {
  Primitive p;
  p.shape = Shape::kBuilding;
  p.half_m = {5, 6, 4.5f};
  p.windows = {3, 3, 1.5f, 1.5f, 0.2f};
  return p;
}

Hit hitOf(const Primitive& p, const Vector3f& origin, const Vector3f& direction) {
  Hit hit;
  EXPECT_TRUE(intersect(p, origin, direction, 1e-3f, hit));
  return hit;
}

TEST(Building, PaneLiesBehindTheWall) {
  const Primitive p = wallWithWindows();
  const Hit pane = hitOf(p, {15, 1.5f, 0}, {-1, 0, 0});  // the middle of a cell
  EXPECT_NEAR(pane.t, 10.2f, 1e-5);
  EXPECT_EQ(pane.part, kPane + 1);
  const Hit wall = hitOf(p, {15, 0, 0}, {-1, 0, 0});  // between two windows
  EXPECT_NEAR(wall.t, 10, 1e-5);
  EXPECT_EQ(wall.part, 1);
}

TEST(Building, SlantedRayMeetsTheSideOfTheRecess) {
  // Enters the opening 5 cm beside its left edge at 45 degrees, so it hits the side 5 cm deep.
  const Hit side = hitOf(wallWithWindows(), {15, 1.5f + 0.70f - 10, 0}, {-1, 1, 0});
  EXPECT_NEAR(side.t, 10.05f, 1e-4);
  EXPECT_EQ(side.part, kReveal + 1);
}

TEST(Primitive, NearerLimitStays) {
  Hit hit{2, 5, 77};
  EXPECT_FALSE(intersect(solid(Shape::kEllipsoid), {6, 0, 0}, {-1, 0, 0}, 1e-3f, hit));
  EXPECT_EQ(hit.t, 2);
  EXPECT_EQ(hit.part, 77);
}

TEST(Noise, DoesNotRepeatAndIsBounded) {
  Footprint fine;
  fine.width_m = 0.001f;
  double sum = 0, sum2 = 0, product = 0;
  const int count = 20000;
  for (int i = 0; i < count; ++i) {
    const double u = 0.37 * i, v = 0.11 * i;
    const float a = texture2(u, v, fine, {1, 5, 0.7f}, 3);
    const float b = texture2(u + 64, v, fine, {1, 5, 0.7f}, 3);
    sum += a;
    sum2 += a * a;
    product += a * b;
    ASSERT_LE(std::abs(a), 3);
  }
  EXPECT_NEAR(sum / count, 0, 0.02);
  EXPECT_GT(sum2 / count, 0.02);
  EXPECT_LT(std::abs(product), 0.05 * sum2);  // not correlated after 64 wavelengths
}

TEST(Noise, FarTexturesAreSmooth) {
  Footprint coarse;
  coarse.width_m = 2;
  EXPECT_EQ(texture2(1.3, 2.7, coarse, {1, 5, 0.7f}, 3), 0);
}

}  // namespace
}  // namespace predictive_stereo::simulation
