#include "evaluation/simulation/models.h"

#include <algorithm>
#include <utility>

namespace predictive_stereo::simulation {
namespace {

void addWheel(Builder& b, double x, double y, double radius) {
  b.add(Shape::kCylinder, kRubber, {x, y, radius}, {radius, radius, 0.11}, 0.06,
        Eigen::AngleAxisd(kPi / 2, Vector3d::UnitX()).toRotationMatrix());
}

void addCar(Builder b, const Vector3d& size, uint32_t seed) {
  Random random(seed);
  const double paint = random.chance(0.5) ? random.uniform(0.05, 0.2) : random.uniform(0.3, 0.8);
  const double l = 0.5 * size.x(), w = 0.5 * size.y(), h = size.z();
  const double belt = 0.62 * h, floor = 0.22;
  const double middle = 0.5 * (belt + floor);
  b.frustum(kPaint, {0, 0, middle}, {l, w, 0.5 * (belt - floor)}, -l + 0.12, l - 0.25, w - 0.06,
            paint);
  const bool estate = random.chance(0.5);
  const double back = estate ? -l + 0.1 : -0.72 * l, front = 0.5 * l;
  const double cabin = 0.5 * (front - back), cabin_x = 0.5 * (front + back);
  b.frustum(kCabin, {cabin_x, 0, 0.5 * (belt + h)}, {cabin, w - 0.08, 0.5 * (h - belt)},
            -cabin + (estate ? 0.25 : 0.6), cabin - 0.75, w - 0.28, paint);
  b.box(kRubber, {0, 0, 0.3}, {l + 0.03, w - 0.05, 0.09}, 0.08);
  for (const double x : {-0.6 * l, 0.62 * l})
    for (const double y : {-w + 0.1, w - 0.1}) addWheel(b, x, y, 0.31);
  for (const double y : {-w + 0.25, w - 0.25}) {
    b.ellipsoid(kLamp, {l - 0.12, y, 0.62}, {0.14, 0.17, 0.09}, 0.85);
    b.box(kMetal, {-l + 0.06, y, 0.68}, {0.06, 0.13, 0.1}, 0.25);
    b.ellipsoid(kPaint, {0.38 * l, (y > 0 ? 1 : -1) * (w + 0.06), 0.98}, {0.07, 0.1, 0.07}, paint);
  }
  b.box(kSign, {-l + 0.02, 0, 0.5}, {0.04, 0.26, 0.06}, 0.85);
  b.box(kSign, {l - 0.02, 0, 0.42}, {0.04, 0.26, 0.06}, 0.85);
}

// Vans, trucks and buses: a cab and a tall body.
void addTransporter(Builder b, const Vector3d& size, uint32_t seed, Kind kind) {
  Random random(seed);
  const double paint = random.uniform(0.25, 0.8);
  const double l = 0.5 * size.x(), w = 0.5 * size.y(), h = size.z();
  const double floor = kind == Kind::kVan ? 0.3 : 0.55;
  const double cab = kind == Kind::kBus ? 0.0 : kind == Kind::kVan ? 1.6 : 2.0;
  const double body = l - 0.5 * cab;
  const double cab_height = kind == Kind::kTruck ? 0.8 * h : 0.96 * h;
  b.frustum(kPaint, {-0.5 * cab, 0, 0.5 * (floor + h)}, {body, w, 0.5 * (h - floor)}, -body + 0.04,
            body - 0.06, w - 0.05, paint);
  if (cab > 0)
    b.frustum(kCabin, {l - 0.5 * cab, 0, 0.5 * (floor + cab_height)},
              {0.5 * cab, w - 0.04, 0.5 * (cab_height - floor)}, -0.5 * cab,
              0.5 * cab - (kind == Kind::kVan ? 0.9 : 0.2), w - 0.12, 0.8 * paint);
  if (kind == Kind::kBus) {
    // Rows of windows.
    for (double x = -l + 1.0; x < l - 0.5; x += 1.5)
      for (const double side : {-1.0, 1.0})
        b.box(kGlass, {x, side * (w - 0.045), 0.62 * h}, {0.62, 0.05, 0.17 * h}, 0.1);
    for (const double end : {-1.0, 1.0})
      b.box(kGlass, {end * (l - 0.05), 0, 0.6 * h}, {0.06, w - 0.25, 0.22 * h}, 0.1);
  } else {
    // Doors, a stripe and letters on the body.
    b.box(kSign, {-l + 0.03, 0, 0.55 * h}, {0.04, 0.7 * w, 0.22 * h}, 0.75);
    for (const double side : {-1.0, 1.0})
      b.box(kSign, {-0.5 * cab, side * (w - 0.03), 0.6 * h}, {0.65 * body, 0.04, 0.16 * h},
            random.uniform(0.3, 0.9));
  }
  b.box(kRubber, {0, 0, 0.5}, {l - 0.1, w - 0.1, 0.2}, 0.07);
  for (const double x : {-0.65 * l, 0.65 * l})
    for (const double y : {-w + 0.12, w - 0.12})
      addWheel(b, x, y, kind == Kind::kVan ? 0.34 : 0.48);
  for (const double y : {-w + 0.2, w - 0.2}) {
    b.box(kMetal, {-l + 0.02, y, 0.9}, {0.05, 0.1, 0.14}, 0.3);
    b.box(kLamp, {l - 0.02, y, 0.75}, {0.05, 0.14, 0.1}, 0.85);
  }
  b.box(kSign, {-l, 0, 0.6}, {0.04, 0.26, 0.06}, 0.85);
}

struct Pose {
  double lean = 0;    // of the upper body [rad]
  double seat = 0.9;  // height of the hip [m]
  double left_leg = 0, right_leg = 0, knee = 0;
};

// Direction of a limb that is swung forward by this angle from hanging down.
Vector3d limb(double angle, double aside = 0) { return {std::sin(angle), aside, -std::cos(angle)}; }

void addBody(Builder& b, const Pose& pose, double scale, uint32_t seed, double reach) {
  Random random(seed);
  const double shirt = random.uniform(0.08, 0.75), trousers = random.uniform(0.05, 0.4);
  const double skin = random.uniform(0.35, 0.6);
  const Vector3d hip(0, 0, pose.seat * scale);
  const Vector3d up(std::sin(pose.lean), 0, std::cos(pose.lean));
  const Vector3d neck = hip + 0.55 * scale * up;
  b.add(Shape::kEllipsoid, kCloth, hip + 0.27 * scale * up,
        {0.14 * scale, 0.23 * scale, 0.36 * scale}, shirt,
        Eigen::AngleAxisd(pose.lean, Vector3d::UnitY()).toRotationMatrix());
  b.ellipsoid(kSkin, neck + Vector3d(0.03, 0, 0.16) * scale,
              {0.10 * scale, 0.085 * scale, 0.13 * scale}, skin);
  b.ellipsoid(kCloth, neck + Vector3d(0.0, 0, 0.22) * scale,
              {0.105 * scale, 0.095 * scale, 0.085 * scale}, random.uniform(0.04, 0.3));
  for (const double side : {-1.0, 1.0}) {
    const double swing = side < 0 ? pose.left_leg : pose.right_leg;
    const Vector3d joint = hip + Vector3d(0, side * 0.1 * scale, 0);
    const Vector3d knee = joint + 0.44 * scale * limb(swing + pose.knee);
    const Vector3d foot = knee + 0.42 * scale * limb(swing - 0.5 * std::abs(swing));
    b.rod(kCloth, joint, knee, 0.085 * scale, trousers);
    b.rod(kCloth, knee, foot, 0.065 * scale, trousers);
    b.ellipsoid(kRubber, foot + Vector3d(0.06, 0, 0) * scale,
                {0.14 * scale, 0.055 * scale, 0.05 * scale}, 0.1);
    const Vector3d shoulder = neck + Vector3d(0, side * 0.22, -0.06) * scale;
    const double arm = reach > 0 ? reach : -swing;
    const Vector3d elbow = shoulder + 0.3 * scale * limb(arm, side * 0.1);
    const Vector3d hand = elbow + 0.28 * scale * limb(arm + 0.3, -side * 0.05);
    b.rod(kCloth, shoulder, elbow, 0.055 * scale, shirt);
    b.rod(kSkin, elbow, hand, 0.045 * scale, skin);
  }
}

void addPerson(Builder b, const Vector3d& size, double stride_m, uint32_t seed) {
  const double phase = stride_m / 1.4 * 2 * kPi;
  Pose pose;
  pose.left_leg = 0.45 * std::sin(phase);
  pose.right_leg = -pose.left_leg;
  const double scale = size.z() / 1.76;
  addBody(b, pose, scale, seed, 0);
  Random random(hashOf(seed, 5));
  if (random.chance(0.4))  // a bag
    b.ellipsoid(kCloth, Vector3d(-0.17, 0, 1.2) * scale, Vector3d(0.12, 0.18, 0.24) * scale,
                random.uniform(0.05, 0.6));
}

void addCyclist(Builder b, const Vector3d& size, double stride_m, uint32_t seed) {
  const double phase = stride_m / 4.0 * 2 * kPi, l = 0.5 * size.x(), r = 0.34;
  Pose pose;
  pose.seat = 0.98;
  pose.lean = 0.5;
  pose.knee = 0.7;
  pose.left_leg = 0.35 * std::sin(phase);
  pose.right_leg = -pose.left_leg;
  addBody(b, pose, size.z() / 1.78, seed, 0.9);
  Random random(hashOf(seed, 6));
  const double frame = random.uniform(0.1, 0.6);
  for (const double x : {-l + r, l - r})
    b.add(Shape::kRing, kRubber, {x, 0, r}, {r, 0.02, r}, 0.08);
  const Vector3d rear(-l + r, 0, r), front(l - r, 0, r), seat(-0.12, 0, 0.9), bar(0.42, 0, 0.98);
  const Vector3d pedals(0.0, 0, 0.3);
  const std::pair<Vector3d, Vector3d> tubes[] = {{rear, seat},  {rear, pedals}, {pedals, seat},
                                                 {pedals, bar}, {seat, bar},    {front, bar}};
  for (const auto& [from, to] : tubes) b.rod(kMetal, from, to, 0.022, frame);
  b.rod(kMetal, bar + Vector3d(0, -0.28, 0.03), bar + Vector3d(0, 0.28, 0.03), 0.018, 0.2);
}

// A flat bunch of leaves with a random orientation.
void addLeaves(Builder& b, const Vector3d& centre, double size, double albedo, Random& random) {
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(random.uniform(0, 2 * kPi), Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(random.uniform(-1.2, 1.2), Vector3d::UnitX()))
                                .toRotationMatrix();
  b.add(Shape::kLeaves, kLeaves, centre, {size, 0.01, size}, albedo * random.uniform(0.6, 1.3), R);
}

}  // namespace

Vector3d sizeOf(Kind kind, uint32_t seed) {
  Random random(hashOf(seed, 77));
  const double a = random.uniform(), c = random.uniform();
  const Vector3d sizes[] = {{3.7 + 1.0 * a, 1.68 + 0.16 * a, 1.42 + 0.2 * c},  // as in Kind
                            {4.9 + 1.0 * a, 1.95, 2.0 + 0.5 * c},
                            {7.5 + 2.0 * a, 2.45, 3.2 + 0.5 * c},
                            {11.5, 2.5, 3.1},
                            {0.55, 0.6, 1.55 + 0.35 * a},
                            {1.75, 0.6, 1.65 + 0.2 * a}};
  return sizes[static_cast<size_t>(kind)];
}

void addThing(Kind kind, uint32_t seed, const Place& place, double stride_m, int object,
              Primitives& out) {
  const Builder builder(place, seed, object, out);
  const Vector3d size = sizeOf(kind, seed);
  if (kind == Kind::kCar) return addCar(builder, size, seed);
  if (kind == Kind::kPerson) return addPerson(builder, size, stride_m, seed);
  if (kind == Kind::kCyclist) return addCyclist(builder, size, stride_m, seed);
  addTransporter(builder, size, seed, kind);
}

void addTree(const Place& place, uint32_t seed, Primitives& out) {
  Builder b(place, seed, 0, out);
  Random random(seed);
  const double trunk = random.uniform(2.2, 3.4), radius = random.uniform(0.11, 0.24);
  const double crown = random.uniform(1.7, 3.0), albedo = random.uniform(0.28, 0.45);
  const Vector3d fork(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), trunk);
  b.rod(kBark, {0, 0, -0.1}, fork, radius, 0.16);
  const Vector3d middle = fork + Vector3d(0, 0, 0.75 * crown);
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * kPi * (i + random.uniform()) / 5;
    b.rod(kBark, fork,
          middle + crown * Vector3d(0.6 * std::cos(angle), 0.6 * std::sin(angle),
                                    random.uniform(-0.1, 0.5)),
          0.35 * radius, 0.13);
  }
  for (int i = 0; i < 60; ++i) {
    const double angle = random.uniform(0, 2 * kPi), lift = random.uniform(-0.8, 1.0);
    const double across = std::sqrt(std::max(0.0, 1 - lift * lift)) * random.uniform(0.3, 1.0);
    addLeaves(b,
              middle + crown * Vector3d(across * std::cos(angle), across * std::sin(angle), lift),
              crown * random.uniform(0.18, 0.36), albedo, random);
  }
}

void addBush(const Place& place, double length_m, double height_m, uint32_t seed, Primitives& out) {
  Builder b(place, seed, 0, out);
  Random random(seed);
  const double albedo = random.uniform(0.26, 0.42), depth = 0.45;
  b.box(kLeaves, {0, 0, 0.46 * height_m}, {0.5 * length_m, 0.75 * depth, 0.46 * height_m},
        0.75 * albedo);
  const int count = static_cast<int>(length_m * height_m * 6) + 4;
  for (int i = 0; i < count; ++i)
    addLeaves(b,
              {random.uniform(-0.5, 0.5) * length_m, random.uniform(-1.1, 1.1) * depth,
               random.uniform(0.1, 1.05) * height_m},
              random.uniform(0.2, 0.4), albedo, random);
}

void addLampPost(const Place& place, Primitives& out) {
  Builder b(place, 3, 0, out);
  b.rod(kMetal, {0, 0, 0}, {0, 0, 1.0}, 0.10, 0.3);
  b.rod(kMetal, {0, 0, 1.0}, {0, 0, 6.5}, 0.055, 0.35);
  b.rod(kMetal, {0, 0, 6.5}, {1.6, 0, 6.9}, 0.035, 0.35);
  b.box(kLamp, {1.8, 0, 6.88}, {0.35, 0.12, 0.06}, 0.6);
}

void addSignPost(const Place& place, uint32_t seed, Primitives& out) {
  Builder b(place, seed, 0, out);
  Random random(seed);
  const double height = random.uniform(2.1, 2.6), size = random.uniform(0.25, 0.4);
  b.rod(kMetal, {0, 0, 0}, {0, 0, height + size}, 0.03, 0.45);
  b.box(kSign, {0.05, 0, height}, {0.015, size, size}, 0.8);
}

void addFence(const Place& place, double length_m, uint32_t seed, Primitives& out) {
  Builder b(place, seed, 0, out);
  b.add(Shape::kBars, kMetal, {0, 0, 0.6}, {0.5 * length_m, 0.02, 0.6}, 0.2);
  for (double x = -0.5 * length_m; x <= 0.5 * length_m; x += 2.5)
    b.rod(kMetal, {x, 0, 0}, {x, 0, 1.3}, 0.04, 0.2);
}

void addHouse(const Place& place, double width_m, double depth_m, uint32_t seed, Primitives& out) {
  Builder b(place, seed, 0, out);
  Random random(seed);
  const int storeys = 2 + random.index(4);
  const double storey = random.uniform(2.9, 3.4), height = storeys * storey + 0.4;
  const Material wall = random.chance(0.35) ? kBrick : kPlaster;
  const double albedo = wall == kBrick ? random.uniform(0.25, 0.42) : random.uniform(0.35, 0.75);
  Windows w;
  const double cells = std::max(2.0, std::round(width_m / random.uniform(2.2, 3.4)));
  w.cell_width_m = static_cast<float>(width_m / cells);
  w.cell_height_m = static_cast<float>(storey);
  w.width_m = static_cast<float>(random.uniform(0.4, 0.6)) * w.cell_width_m;
  w.height_m = static_cast<float>(random.uniform(1.3, 1.8));
  w.recess_m = static_cast<float>(random.uniform(0.1, 0.25));
  b.add(Shape::kBuilding, wall, {-0.5 * depth_m, 0, 0.5 * height},
        {0.5 * depth_m, 0.5 * width_m, 0.5 * height}, albedo)
      .windows = w;
  // A plinth, a cornice, a door, a roof, a chimney, a rain pipe, balconies.
  b.box(kPlaster, {-0.5 * depth_m, 0, 0.3}, {0.5 * depth_m + 0.06, 0.5 * width_m + 0.0, 0.3},
        0.7 * albedo);
  b.box(kPlaster, {-0.5 * depth_m, 0, height - 0.15}, {0.5 * depth_m + 0.3, 0.5 * width_m, 0.15},
        0.85 * albedo);
  if (random.chance(0.7)) {
    const double rise = random.uniform(1.5, 3.5);
    b.frustum(kRoof, {-0.5 * depth_m, 0, height + 0.5 * rise},
              {0.5 * depth_m + 0.25, 0.5 * width_m, 0.5 * rise}, -0.1, 0.1, 0.5 * width_m - 0.05,
              random.uniform(0.15, 0.35));
    b.box(kBrick, {-0.6 * depth_m, random.uniform(-0.3, 0.3) * width_m, height + 0.9 * rise},
          {0.35, 0.35, 0.9}, 0.3);
  }
  const double door = (random.index(3) - 1) * static_cast<double>(w.cell_width_m);
  b.box(kPaint, {0.04, door, 1.1}, {0.06, 0.55, 1.1}, random.uniform(0.08, 0.5));
  b.rod(kMetal, {0.07, 0.5 * width_m - 0.15, 0}, {0.07, 0.5 * width_m - 0.15, height}, 0.05, 0.4);
  if (random.chance(0.4)) {
    for (int s = 1; s < storeys; ++s) {
      const double y = (random.index(2) == 0 ? -1 : 1) * static_cast<double>(w.cell_width_m);
      const double z = s * storey + 0.15;
      b.box(kPlaster, {0.55, y, z}, {0.55, 0.95, 0.08}, 0.9 * albedo);
      b.add(Shape::kBars, kMetal, {1.05, y, z + 0.5}, {0.95, 0.02, 0.5}, 0.25,
            Eigen::AngleAxisd(kPi / 2, Vector3d::UnitZ()).toRotationMatrix());
    }
  }
  if (random.chance(0.25))  // a shop sign over the pavement
    b.box(kSign, {0.08, 0.1 * width_m, 3.1}, {0.08, 0.22 * width_m, 0.35},
          random.uniform(0.5, 0.9));
}

}  // namespace predictive_stereo::simulation
