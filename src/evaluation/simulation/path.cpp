#include "evaluation/simulation/path.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "evaluation/simulation/noise.h"
#include "evaluation/simulation/worlds.h"

namespace predictive_stereo::simulation {
namespace {

constexpr double kRadPerDeg = kPi / 180;
constexpr double kFade_s = 0.4;  // a shake fades in and out in this time
constexpr double kStep_m = 0.05, kTick_s = 0.002;
constexpr double kBendSpeed_mps = 4.5, kAccel_mps2 = 1.8;
constexpr double kLeftBend_m = 24, kRightBend_m = 15;

// Heading after this part of a bend of 90 degrees, whose curvature follows sin^2.
double turned(double share) { return 0.5 * kPi * (share - std::sin(2 * kPi * share) / (2 * kPi)); }

// Distance that a bend of this length leads ahead; it leads the same distance sideways.
double reachOfBend(double length_m) {
  double ahead = 0;
  const int steps = 1000;
  for (int i = 0; i < steps; ++i) ahead += std::cos(turned((i + 0.5) / steps)) * length_m / steps;
  return ahead;
}

// Row of a table at a position between its indices.
template <class Row>
Row interpolate(const std::vector<Row>& table, double position) {
  position = std::clamp(position, 0.0, static_cast<double>(table.size() - 2));
  const auto i = static_cast<size_t>(position);
  return table[i] + (position - static_cast<double>(i)) * (table[i + 1] - table[i]);
}

Isometry3d poseOf(const Vector3d& position_m, double heading, double pitch, double roll) {
  return Eigen::Translation3d(position_m) *
         (Eigen::AngleAxisd(heading, Vector3d::UnitZ()) *
          Eigen::AngleAxisd(pitch, Vector3d::UnitY()) * Eigen::AngleAxisd(roll, Vector3d::UnitX()));
}

// Path of a vehicle along the streets of the town, and its speed profile.
class Route : public Path {
 public:
  // @param duration_s  the trajectory is computed from 0 to this time.
  Route(const Drive& drive, double duration_s, uint32_t seed) : drive_(drive), seed_(seed) {
    const double length_m = drive.cruise_mps * duration_s + 150;
    layPath(length_m);
    std::vector<double> stops;
    for (double stop_m = drive.stop_first_m; stop_m >= 0 && stop_m < length_m;
         stop_m += drive.stop_every_m) {
      stops.push_back(stop_m);
      if (drive.stop_every_m <= 0) break;
    }
    driveAlong(stops, speedLimits(stops), static_cast<size_t>((duration_s + 1) / kTick_s) + 2);
  }

  Place placeAhead(double time_s, double gap_m) const override {
    const Vector3d at =
        interpolate(path_, (interpolate(states_, time_s / kTick_s).x() + gap_m) / kStep_m);
    return {{at.x(), at.y(), 0}, at.z()};
  }
  Isometry3d bodyAt(double time_s) const override {
    const Vector2d state = interpolate(states_, time_s / kTick_s);
    const double way = state.x(), accel_mps2 = state.y();
    const Place place = placeAt(time_s);
    double pitch = 0, roll = 0, heave = 0;  // pitch: down is positive
    if (drive_.sways) {
      // Road roughness is a function of the distance, so a standing camera does not move.
      pitch = 0.0035 * noise2(way / 4.0, 0.5, seed_) + 0.0015 * noise2(way / 1.3, 0.5, seed_ + 1);
      pitch -= 0.0025 * accel_mps2;
      roll = 0.004 * noise2(way / 5.0, 0.5, seed_ + 2);
      heave = 0.012 * noise2(way / 3.0, 0.5, seed_ + 3);
    }
    const double look =
        drive_.look_deg * kPi / 180 * std::sin(2 * kPi * time_s / drive_.look_period_s);
    return poseOf(place.position_m + Vector3d(0, 0, heave), place.heading_rad + look, pitch, roll);
  }

 private:
  void layPath(double length_m) {
    Vector3d at(drive_.start_m, -kLane_m, 0);
    path_ = {at};
    bends_ = {false};
    const auto advance = [&](double step, double turn, bool bend) {
      const double middle = at.z() + 0.5 * turn;
      at += Vector3d(step * std::cos(middle), step * std::sin(middle), turn);
      path_.push_back(at);
      bends_.push_back(bend);
    };
    size_t junction = 0;
    while (path_.size() * kStep_m < length_m) {
      const char turn = drive_.turns[junction++ % drive_.turns.size()];
      const double cosine = std::round(std::cos(at.z())), sine = std::round(std::sin(at.z()));
      const double position = at.x() * cosine + at.y() * sine;
      const double crossing = kPitch_m * std::floor(position / kPitch_m + 1);
      // End of the straight part: half a block behind the junction, or the start of a bend that
      // ends in the middle of a lane. A left turn ends in a lane beyond the junction's middle.
      const double bend = turn == 'L' ? kLeftBend_m : kRightBend_m;
      const double target = turn == 'S'
                                ? crossing + 0.25 * kPitch_m
                                : crossing + (turn == 'L' ? kLane_m : -kLane_m) - reachOfBend(bend);
      const int steps = std::max(0, static_cast<int>((target - position) / kStep_m));
      for (int i = 0; i < steps; ++i) advance(kStep_m, 0, false);
      if (turn == 'S') continue;
      const int bend_steps = static_cast<int>(bend / kStep_m);
      const double sign = turn == 'L' ? 1 : -1;
      for (int i = 0; i < bend_steps; ++i)
        advance(
            kStep_m,
            sign * (turned((i + 1.0) / bend_steps) - turned(static_cast<double>(i) / bend_steps)),
            true);
      // Exactly quarter turns: rounding to whole steps must not accumulate over many bends.
      at.z() = kPi / 2 * std::round(at.z() / (kPi / 2));
    }
  }

  // Highest speed at each step that still allows braking for bends and stops ahead.
  std::vector<double> speedLimits(const std::vector<double>& stops) const {
    std::vector<double> limit(path_.size());
    for (size_t i = 0; i < limit.size(); ++i)
      limit[i] = bends_[i] ? std::min(kBendSpeed_mps, drive_.cruise_mps) : drive_.cruise_mps;
    for (const double stop : stops) limit[static_cast<size_t>(stop / kStep_m)] = 0;
    for (size_t i = limit.size() - 1; i-- > 0;)
      limit[i] = std::min(limit[i],
                          std::sqrt(limit[i + 1] * limit[i + 1] + 2 * drive_.brake_mps2 * kStep_m));
    return limit;
  }

  void driveAlong(const std::vector<double>& stops, const std::vector<double>& limit,
                  size_t ticks) {
    double way_m = 0, speed_mps = limit[0], accel_mps2 = 0;
    size_t next_stop = 0;
    double waited_s = 0;
    states_.reserve(ticks);
    for (size_t i = 0; i < ticks; ++i) {
      states_.emplace_back(way_m, accel_mps2);
      const auto index = std::min(static_cast<size_t>(way_m / kStep_m), limit.size() - 1);
      const double rest = way_m / kStep_m - static_cast<double>(index);
      const size_t after = std::min(index + 1, limit.size() - 1);
      double allowed =
          std::sqrt((1 - rest) * limit[index] * limit[index] + rest * limit[after] * limit[after]);
      if (next_stop < stops.size() && way_m > stops[next_stop] - 0.002) {
        waited_s += kTick_s;
        allowed = 0;
        if (waited_s > drive_.stop_s) {
          ++next_stop;
          waited_s = 0;
          allowed = 0.5;
        }
      } else if (allowed < 0.1 && drive_.cruise_mps > 0) {
        allowed = 0.1;  // leaves a stop, or drives the last centimetres to one
      }
      const double before = speed_mps;
      speed_mps = std::min(allowed, before + kAccel_mps2 * kTick_s);
      way_m += 0.5 * (before + speed_mps) * kTick_s;
      // Low-pass filter: the pitch follows the acceleration through the springs.
      const double accel = (speed_mps - before) / kTick_s;
      accel_mps2 += (std::max(accel, -10.0) - accel_mps2) * (kTick_s / 0.15);
    }
  }

  Drive drive_;
  uint32_t seed_;
  std::vector<Vector3d> path_;    // x, y, heading at every kStep_m of distance
  std::vector<bool> bends_;       // where the path bends
  std::vector<Vector2d> states_;  // distance [m], acceleration [m/s^2] every kTick_s
};

}  // namespace

WaypointPath::WaypointPath(const std::vector<Waypoint>& waypoints, const std::vector<Shake>& shakes,
                           uint32_t seed)
    : shakes_(shakes), seed_(seed) {
  if (waypoints.empty()) throw std::invalid_argument("waypoints: give at least one");
  for (const Waypoint& w : waypoints) {
    if (!times_s_.empty() && w.time_s <= times_s_.back())
      throw std::invalid_argument("waypoints: time_s = " + std::to_string(w.time_s) +
                                  " must be after the previous one, " +
                                  std::to_string(times_s_.back()));
    times_s_.push_back(w.time_s);
    values_.emplace_back();
    values_.back() << w.position_m, w.heading_deg * kRadPerDeg, w.pitch_deg * kRadPerDeg,
        w.roll_deg * kRadPerDeg;
  }
  slopes_.assign(values_.size(), Coordinates::Zero());  // at rest at both ends
  for (size_t i = 1; i + 1 < values_.size(); ++i) {
    const double before_s = times_s_[i] - times_s_[i - 1], after_s = times_s_[i + 1] - times_s_[i];
    for (int k = 0; k < 6; ++k) {
      const double before = (values_[i][k] - values_[i - 1][k]) / before_s;
      const double after = (values_[i + 1][k] - values_[i][k]) / after_s;
      if (before * after <= 0) continue;
      // Weighted harmonic mean.
      const double a = 2 * after_s + before_s, b = after_s + 2 * before_s;
      slopes_[i][k] = (a + b) / (a / before + b / after);
    }
  }
}

WaypointPath::Coordinates WaypointPath::smoothAt(double time_s) const {
  if (time_s <= times_s_.front()) return values_.front();
  if (time_s >= times_s_.back()) return values_.back();
  const auto next = static_cast<size_t>(std::upper_bound(times_s_.begin(), times_s_.end(), time_s) -
                                        times_s_.begin());
  const size_t i = next - 1;
  const double span_s = times_s_[next] - times_s_[i], t = (time_s - times_s_[i]) / span_s;
  const double rest = 1 - t;
  return (1 + 2 * t) * rest * rest * values_[i] + t * rest * rest * span_s * slopes_[i] +
         t * t * (3 - 2 * t) * values_[next] - t * t * rest * span_s * slopes_[next];
}

WaypointPath::Coordinates WaypointPath::shakeAt(double time_s) const {
  Coordinates sum = Coordinates::Zero();
  for (size_t i = 0; i < shakes_.size(); ++i) {
    const Shake& shake = shakes_[i];
    const double inside_s = std::min(time_s - shake.from_s, shake.until_s - time_s);
    const double share = std::clamp(inside_s / kFade_s, 0.0, 1.0);
    if (share <= 0) continue;
    for (int k = 0; k < 6; ++k) {
      const double size = k < 3 ? shake.position_m : shake.angle_deg * kRadPerDeg;
      sum[k] += share * share * (3 - 2 * share) * size *
                noise2(time_s / shake.period_s, 0.0,
                       hashOf(seed_, static_cast<uint32_t>(i), static_cast<uint32_t>(k)));
    }
  }
  return sum;
}

Isometry3d WaypointPath::bodyAt(double time_s) const {
  const Coordinates c = smoothAt(time_s) + shakeAt(time_s);
  return poseOf(c.head<3>(), c[3], c[4], c[5]);
}

Place WaypointPath::placeAhead(double time_s, double gap_m) const {
  const Coordinates c = smoothAt(time_s);
  return {{c.x() + gap_m * std::cos(c[3]), c.y() + gap_m * std::sin(c[3]), 0}, c[3]};
}

std::unique_ptr<Path> makePath(const Scene& scene, double duration_s, uint32_t seed) {
  if (scene.waypoints.empty()) return std::make_unique<Route>(scene.drive, duration_s, seed);
  return std::make_unique<WaypointPath>(scene.waypoints, scene.shakes, seed);
}

}  // namespace predictive_stereo::simulation
