#include <algorithm>
#include <cmath>

#include "evaluation/simulation/worlds.h"

namespace predictive_stereo::simulation {
namespace {

constexpr double kFarHouses_m = 330, kDetails_m = 150;
constexpr double kBlock_m = 0.5 * kPitch_m - kKerb_m;  // half the width of a block, kerb to kerb

double toNearestStreet(double x) { return x - kPitch_m * std::round(x / kPitch_m); }

// One side of a block: `along` runs along the kerb, `inward` from the kerb into the block.
struct Side {
  Vector2d middle_m;
  double heading_rad;  // out of the block, towards the street

  Place place(double along, double inward, double turn_rad = 0) const {
    const Vector2d out(std::cos(heading_rad), std::sin(heading_rad));
    const Vector2d right(-out.y(), out.x());
    const Vector2d at = middle_m + right * along - out * inward;
    return {{at.x(), at.y(), inward > 0 ? kPavement_m : 0.0}, heading_rad + turn_rad};
  }
};

struct TownBuilder {
  const Scene& scene;
  const View& view;
  Primitives& out;

  bool sees(const Place& place, double radius, double limit = kDetails_m) const {
    const Vector2d centre = place.position_m.head<2>();
    // The margin is for shadows that fall into the view.
    return view.distance(centre) < limit && view.reaches(centre, radius + 12);
  }

  void addLot(const Side& side, double along, double width, uint32_t seed) const {
    Random random(seed);
    const double kind = random.uniform(), setback = kSidewalk_m;
    const double garden = random.chance(0.6) ? 0.0 : random.uniform(2.0, 5.0);
    const Place front = side.place(along, setback + 0.4);
    if (kind < 0.68) {
      const Place house = side.place(along, setback + garden);
      if (!sees(house, 0.7 * width + 10, kFarHouses_m)) return;
      const size_t before = out.size();
      addHouse(house, width - (garden > 0 ? 1.5 : 0.0), 10, hashOf(seed, 1), out);
      // Distant houses have only walls and a roof.
      if (view.distance(house.position_m.head<2>()) > kDetails_m && out.size() > before + 4)
        out.resize(before + 4);
      if (garden == 0 || !sees(front, width)) return;
    } else if (!sees(front, width)) {
      return;
    } else if (kind < 0.86) {
      for (int i = 0; i < 2; ++i)
        addTree(side.place(along + (i - 0.5) * 0.5 * width, setback + random.uniform(3, 8)),
                hashOf(seed, 2, static_cast<uint32_t>(i)), out);
    }
    const double border = random.uniform();
    if (border < 0.5) {
      addBush({front.position_m, front.heading_rad + kPi / 2}, width - 1, random.uniform(0.9, 1.9),
              hashOf(seed, 3), out);
    } else if (border < 0.8) {
      addFence({front.position_m, front.heading_rad + kPi / 2}, width - 0.6, hashOf(seed, 4), out);
    } else {
      Builder(front, seed, 0, out, 5)
          .box(kBrick, {0, 0, 0.9}, {0.15, 0.5 * width - 0.2, 0.9}, 0.34);
    }
  }

  void addSide(const Side& side, double reach, uint32_t seed) const {
    Random random(seed);
    for (double along = -reach; along < reach - 7;) {
      double width = random.uniform(9, 17);
      if (along + width > reach - 7) width = reach - along;
      addLot(side, along + 0.5 * width, width, random.bits());
      along += width;
    }
    // Along the kerb: trees, lamps and signs.
    for (double along = -kBlock_m + 6; along < kBlock_m - 6; along += random.uniform(6, 9)) {
      const uint32_t id = random.bits();
      const double what = random.uniform();
      const Place place = side.place(along, 0.75);
      if (what < scene.trees) {
        if (sees(place, 6)) addTree(place, id, out);
      } else if (what < scene.trees + 0.25) {
        if (sees(place, 3)) addLampPost(place, out);
      } else if (what < scene.trees + 0.4) {
        if (sees(place, 1)) addSignPost(side.place(along, 0.5, kPi / 2), id, out);
      }
    }
    for (double along = -kBlock_m + 9; along < kBlock_m - 9; along += 6.3) {
      const uint32_t id = random.bits();
      const double shift = random.uniform(-0.3, 0.3), turn = random.uniform(-0.03, 0.03);
      const Place place = side.place(along + shift, -1.0, kPi / 2 * (id & 1 ? 1 : -1) + turn);
      // All are drawn: which cars are parked must not depend on the view.
      const bool is_parked = random.chance(scene.parked_cars), is_van = random.chance(0.12);
      if (is_parked && sees(place, 3))
        addThing(is_van ? Kind::kVan : Kind::kCar, id, place, 0, 0, out);
    }
  }
};

}  // namespace

Marking markingAt(double x_m, double y_m) {
  double across = toNearestStreet(y_m), along = toNearestStreet(x_m);
  bool along_y = false;
  double position = x_m;
  if (std::abs(across) > kKerb_m) {
    std::swap(across, along);
    along_y = true;
    position = y_m;
  }
  const double side = std::abs(across), from_crossing = std::abs(along);
  Marking best;
  best.inside_m = -1;
  if (side > kKerb_m || from_crossing < kKerb_m + 0.4) return best;
  // Adds a rectangle, given the position across and along it. The marking in which the point is
  // deepest wins.
  const auto paint = [&](double across_now, double across_low, double across_high, double along_now,
                         double along_low, double along_high, float strength) {
    const double in_across = std::min(across_now - across_low, across_high - across_now);
    const double in_along = std::min(along_now - along_low, along_high - along_now);
    const double inside = std::min(in_across, in_along);
    if (inside > best.inside_m)
      best = {strength, static_cast<float>(inside), (in_along < in_across) != along_y};
  };
  constexpr double kParking_m = kKerb_m - 2.1;  // end of the lane
  const double dash = position - 9 * std::floor(position / 9);
  if (from_crossing > 14) paint(side, -0.07, 0.07, dash, 0, 3.5, 1.0f);
  paint(side, kParking_m, kParking_m + 0.12, from_crossing, 12, 50, 0.8f);
  // A zebra crossing before each junction, and a stop line.
  paint(side - std::floor(side), 0, 0.5, from_crossing, kKerb_m + 1.2, kKerb_m + 4.2, 1.0f);
  paint(side, 0.1, kParking_m, from_crossing, kKerb_m + 5.2, kKerb_m + 5.6, 1.0f);
  return best;
}

bool View::reaches(const Vector2d& centre_m, double radius_m) const {
  const Vector2d offset = centre_m - position_m.head<2>();
  const double ahead = forward.dot(offset);
  const double aside = std::abs(forward.x() * offset.y() - forward.y() * offset.x());
  if (ahead < -radius_m) return false;
  // Distance from the nearer side of the wedge.
  return aside - ahead * tan_half_angle <=
         radius_m * std::sqrt(1 + tan_half_angle * tan_half_angle);
}

void addTown(const Scene& scene, uint32_t town_seed, const View& view, Primitives& out) {
  Builder({}, 0, 0, out).add(Shape::kGround, kRoad, Vector3d::Zero(), Vector3d::Ones(), 0);
  const int reach = static_cast<int>(kFarHouses_m / kPitch_m) + 1;
  const int column = static_cast<int>(std::floor(view.position_m.x() / kPitch_m));
  const int row = static_cast<int>(std::floor(view.position_m.y() / kPitch_m));
  const TownBuilder builder{scene, view, out};
  for (int i = column - reach; i <= column + reach; ++i) {
    for (int j = row - reach; j <= row + reach; ++j) {
      const Vector2d centre((i + 0.5) * kPitch_m, (j + 0.5) * kPitch_m);
      if (!view.reaches(centre, 0.75 * kPitch_m)) continue;
      const uint32_t seed = hashOf(town_seed, static_cast<uint32_t>(i), static_cast<uint32_t>(j));
      Builder({}, 0, 0, out)
          .box(kPavement, {centre.x(), centre.y(), 0.5 * kPavement_m - 0.1},
               {kBlock_m, kBlock_m, 0.5 * kPavement_m + 0.1}, 0.5)
          .seed = seed;
      for (int side = 0; side < 4; ++side) {
        const double heading = side * kPi / 2;
        const Vector2d outward(std::cos(heading), std::sin(heading));
        // The corners belong to the houses of two opposite sides.
        const double reach_m = kBlock_m - kSidewalk_m - (side % 2 ? 10.2 : 0.0);
        builder.addSide({centre + kBlock_m * outward, heading}, reach_m,
                        hashOf(seed, static_cast<uint32_t>(side)));
      }
    }
  }
}

}  // namespace predictive_stereo::simulation
