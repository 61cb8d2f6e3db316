#include "evaluation/simulation/traffic.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "evaluation/simulation/worlds.h"

namespace predictive_stereo::simulation {
namespace {

// A rectangle on the ground.
struct Outline {
  Vector2d centre, ahead;
  double half_length, half_width;

  Outline(const Place& place, const Vector3d& size, double margin)
      : centre(place.position_m.head<2>()),
        ahead(place.ahead()),
        half_length(0.5 * size.x() + margin),
        half_width(0.5 * size.y() + margin) {}

  double extentAlong(const Vector2d& axis) const {
    return half_length * std::abs(axis.dot(ahead)) +
           half_width * std::abs(axis.x() * ahead.y() - axis.y() * ahead.x());
  }
};

bool overlap(const Outline& a, const Outline& b) {
  const Vector2d offset = b.centre - a.centre;
  for (const Vector2d& axis :
       {a.ahead, Vector2d(-a.ahead.y(), a.ahead.x()), b.ahead, Vector2d(-b.ahead.y(), b.ahead.x())})
    if (std::abs(axis.dot(offset)) > a.extentAlong(axis) + b.extentAlong(axis)) return false;
  return true;
}

// Whether it never collides with the camera's body or with another moving object.
bool isFree(const Mover& mover, const std::vector<Mover>& others, const Path& path,
            const Vector3d& body_m) {
  const Vector3d size = sizeOf(mover.kind, mover.seed);
  for (double t = std::max(0.0, mover.from_s); t <= mover.until_s; t += 0.2) {
    const Place place = mover.placeAt(t, path);
    const Outline outline(place, size, 0.15);
    if (overlap(outline, Outline(path.placeAt(t), body_m, 0.35))) return false;
    for (const Mover& other : others) {
      if (t < other.from_s || t > other.until_s) continue;
      const Place there = other.placeAt(t, path);
      if ((there.position_m - place.position_m).squaredNorm() > 225) continue;
      if (overlap(outline, Outline(there, sizeOf(other.kind, other.seed), 0.15))) return false;
    }
  }
  return true;
}

// The street of the camera at a time.
struct Street {
  double heading_rad;  // of the camera, rounded to quarter turns
  Vector2d ahead, left;
  double along_m;   // of the camera, on the axis `ahead`
  double middle_m;  // of the street, on the axis `left`
  bool valid;       // false while it turns

  Street(const Path& path, double time_s) {
    const Place place = path.placeAt(time_s);
    heading_rad = kPi / 2 * std::round(place.heading_rad / (kPi / 2));
    ahead = Place{{}, heading_rad}.ahead();
    left = {-ahead.y(), ahead.x()};
    const Vector2d at = place.position_m.head<2>();
    along_m = ahead.dot(at);
    middle_m = kPitch_m * std::round(left.dot(at) / kPitch_m);
    valid = std::abs(place.heading_rad - heading_rad) < 0.05;
  }

  Place place(double along, double lateral, double turn_rad, bool pavement) const {
    const Vector2d at = ahead * along + left * (middle_m + lateral);
    return {{at.x(), at.y(), pavement ? kPavement_m : 0.0}, heading_rad + turn_rad};
  }
};

struct TrafficMaker {
  const Path& path;
  const Vector3d body_m;
  const double duration_s;
  const uint32_t seed;
  int next_id = 1;
  std::vector<Mover> movers = {};

  void addCompanion(const Companion& companion) {
    Mover mover = makeMover(companion.kind, 1);
    mover.goes_along = true;
    mover.along = companion;
    mover.along.gap_m += 0.5 * sizeOf(mover.kind, mover.seed).x();
    mover.until_s = duration_s;
    movers.push_back(mover);
  }

  void addWalk(const Walk& walk) {
    const Vector2d way = walk.to_m - walk.from_m;
    Mover mover = makeMover(walk.kind, 3);
    mover.met_s = mover.from_s = walk.start_s;
    mover.until_s = walk.start_s + way.norm() / walk.speed_mps;
    mover.met = {{walk.from_m.x(), walk.from_m.y(), 0}, std::atan2(way.y(), way.x())};
    mover.speed_mps = walk.speed_mps;
    if (!isFree(mover, movers, path, body_m))
      throw std::invalid_argument("walk " + std::to_string(mover.id) +
                                  " collides with the camera or with another one; change its path");
    movers.push_back(mover);
  }

  // Candidates of one kind after the other; those that would collide are left out.
  // @param make  sets kind, speed and place; false: there is none now.
  void addEncounters(double period_s, uint32_t kind, double reach_s,
                     bool (*make)(const Street&, Random&, Mover&)) {
    if (period_s <= 0) return;
    Random random(hashOf(seed, 2, kind));
    for (double t = -reach_s + random.uniform(0, period_s); t < duration_s + reach_s;
         t += period_s * random.uniform(0.6, 1.4)) {
      Mover mover;
      mover.seed = random.bits();
      mover.met_s = t;
      const Street street(path, std::clamp(t, 0.0, duration_s));
      Random own(mover.seed);
      const bool possible = make(street, own, mover);
      if (!street.valid || !possible) continue;
      mover.from_s = t - reach_s;
      mover.until_s = t + reach_s;
      mover.id = next_id;
      if (!isFree(mover, movers, path, body_m)) continue;
      movers.push_back(mover);
      ++next_id;
    }
  }

  Mover makeMover(Kind kind, uint32_t group) {
    Mover mover;
    mover.id = next_id++;
    mover.kind = kind;
    mover.seed = hashOf(seed, group, static_cast<uint32_t>(mover.id));
    return mover;
  }
};

bool makeOncomingCar(const Street& s, Random& r, Mover& m) {
  m.kind = r.chance(0.75) ? Kind::kCar : r.chance(0.6) ? Kind::kVan : Kind::kTruck;
  m.speed_mps = r.uniform(6, 12);
  m.met = s.place(s.along_m + r.uniform(3, 12), kLane_m + r.uniform(-0.1, 0.2), kPi, false);
  return true;
}

bool makeCrossingCar(const Street& s, Random& r, Mover& m) {
  m.kind = r.chance(0.7) ? Kind::kCar : Kind::kVan;
  m.speed_mps = r.uniform(5, 10);
  const double junction = kPitch_m * std::floor(s.along_m / kPitch_m + 1);
  if (junction - s.along_m > 55) return false;
  const double side = r.chance(0.5) ? 1 : -1;  // it drives to the left or to the right
  m.met = s.place(junction + side * kLane_m, 0, side * kPi / 2, false);
  return true;
}

bool makeCyclist(const Street& s, Random& r, Mover& m) {
  m.kind = Kind::kCyclist;
  const bool right = r.chance(0.65);
  m.speed_mps = r.uniform(3.2, 5.5);
  m.met = s.place(s.along_m + r.uniform(6, 28), right ? -3.5 : 3.5, right ? 0 : kPi, false);
  return true;
}

bool makeCrossingPerson(const Street& s, Random& r, Mover& m) {
  m.kind = Kind::kPerson;
  m.speed_mps = r.uniform(1.0, 2.0);
  const bool to_left = r.chance(0.5);
  // On the zebra crossing of the next junction if it is near, else anywhere.
  const double junction = kPitch_m * std::floor(s.along_m / kPitch_m + 1) - kKerb_m - 2.7;
  const double ahead = junction - s.along_m;
  const double along =
      ahead > 5 && ahead < 40 ? junction + r.uniform(-1, 1) : s.along_m + r.uniform(9, 32);
  m.met = s.place(along, r.uniform(-3, 3), (to_left ? 1 : -1) * kPi / 2 + r.uniform(-0.15, 0.15),
                  false);
  return true;
}

bool makeWalker(const Street& s, Random& r, Mover& m) {
  m.kind = Kind::kPerson;
  m.speed_mps = r.uniform(0.9, 2.0);
  const double side = r.chance(0.5) ? 1 : -1;
  m.met = s.place(s.along_m + r.uniform(5, 45), side * (kKerb_m + r.uniform(1.3, 2.6)),
                  r.chance(0.5) ? 0 : kPi, true);
  return true;
}

// Crosses the view, up to 35 degrees from straight across.
bool makePasser(const Street& s, Random& r, Mover& m) {
  m.kind = Kind::kPerson;
  m.speed_mps = r.uniform(0.9, 1.6);
  const double side = r.chance(0.5) ? 1 : -1;
  m.met = s.place(s.along_m + r.uniform(0.8, 6), 0, side * (kPi / 2 + r.uniform(-0.6, 0.6)), false);
  return true;
}

}  // namespace

Place Mover::placeAt(double time_s, const Path& path) const {
  if (!goes_along) {
    Place place = met;
    place.position_m.head<2>() += speed_mps * (time_s - met_s) * met.ahead();
    return place;
  }
  Place place = path.placeAhead(
      time_s, along.gap_m + along.swing_m * std::sin(2 * kPi * time_s / along.period_s + id));
  const Vector2d ahead = place.ahead();
  place.position_m.head<2>() += along.left_m * Vector2d(-ahead.y(), ahead.x());
  return place;
}

Vector3d Mover::velocityAt(double time_s, const Path& path) const {
  constexpr double kHalf_s = 0.005;
  const double before_s = std::max(0.0, time_s - kHalf_s), after_s = time_s + kHalf_s;
  return (placeAt(after_s, path).position_m - placeAt(before_s, path).position_m) /
         (after_s - before_s);
}

std::vector<Mover> makeTraffic(const Traffic& traffic, const Path& path, const Vector3d& body_m,
                               double duration_s, uint32_t seed) {
  TrafficMaker maker{path, body_m, duration_s, seed};
  for (const Companion& companion : traffic.companions) maker.addCompanion(companion);
  for (const Walk& walk : traffic.walks) maker.addWalk(walk);
  maker.addEncounters(traffic.oncoming_s, 2, 14, makeOncomingCar);
  maker.addEncounters(traffic.crossing_cars_s, 3, 12, makeCrossingCar);
  maker.addEncounters(traffic.cyclists_s, 4, 25, makeCyclist);
  maker.addEncounters(traffic.crossing_people_s, 5, 12, makeCrossingPerson);
  maker.addEncounters(traffic.walkers_s, 6, 50, makeWalker);
  maker.addEncounters(traffic.passers_s, 7, 7, makePasser);
  return std::move(maker.movers);
}

}  // namespace predictive_stereo::simulation
