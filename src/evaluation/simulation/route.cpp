#include "evaluation/simulation/route.h"

#include <algorithm>
#include <cmath>

#include "evaluation/simulation/town.h"

namespace predictive_stereo::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979;
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

}  // namespace

Route::Route(const Drive& drive, double duration_s, uint32_t seed) : drive_(drive), seed_(seed) {
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

void Route::layPath(double length_m) {
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
    // End of the straight part: half a block behind the junction, or the start of a bend that ends
    // in the middle of a lane. A left turn ends in a lane beyond the junction's middle.
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
      advance(kStep_m,
              sign * (turned((i + 1.0) / bend_steps) - turned(static_cast<double>(i) / bend_steps)),
              true);
    // Exactly quarter turns: rounding to whole steps must not accumulate over many bends.
    at.z() = kPi / 2 * std::round(at.z() / (kPi / 2));
  }
}

// Highest speed at each step that still allows braking for bends and stops ahead.
std::vector<double> Route::speedLimits(const std::vector<double>& stops) const {
  std::vector<double> limit(path_.size());
  for (size_t i = 0; i < limit.size(); ++i)
    limit[i] = bends_[i] ? std::min(kBendSpeed_mps, drive_.cruise_mps) : drive_.cruise_mps;
  for (const double stop : stops) limit[static_cast<size_t>(stop / kStep_m)] = 0;
  for (size_t i = limit.size() - 1; i-- > 0;)
    limit[i] = std::min(limit[i],
                        std::sqrt(limit[i + 1] * limit[i + 1] + 2 * drive_.brake_mps2 * kStep_m));
  return limit;
}

void Route::driveAlong(const std::vector<double>& stops, const std::vector<double>& limit,
                       size_t ticks) {
  State state{0, limit[0], 0};
  size_t next_stop = 0;
  double waited_s = 0;
  states_.reserve(ticks);
  for (size_t i = 0; i < ticks; ++i) {
    states_.push_back(state);
    const auto index = std::min(static_cast<size_t>(state.way_m / kStep_m), limit.size() - 1);
    const double rest = state.way_m / kStep_m - static_cast<double>(index);
    const size_t after = std::min(index + 1, limit.size() - 1);
    double allowed =
        std::sqrt((1 - rest) * limit[index] * limit[index] + rest * limit[after] * limit[after]);
    if (next_stop < stops.size() && state.way_m > stops[next_stop] - 0.002) {
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
    const double before = state.speed_mps;
    state.speed_mps = std::min(allowed, before + kAccel_mps2 * kTick_s);
    state.way_m += 0.5 * (before + state.speed_mps) * kTick_s;
    // Low-pass filter: the pitch follows the acceleration through the springs.
    const double accel = (state.speed_mps - before) / kTick_s;
    state.accel_mps2 += (std::max(accel, -10.0) - state.accel_mps2) * (kTick_s / 0.15);
  }
}

Route::State Route::stateAt(double time_s) const {
  const double tick = std::clamp(time_s / kTick_s, 0.0, static_cast<double>(states_.size() - 2));
  const auto i = static_cast<size_t>(tick);
  const double rest = tick - static_cast<double>(i);
  const State &a = states_[i], &b = states_[i + 1];
  return {a.way_m + rest * (b.way_m - a.way_m), a.speed_mps + rest * (b.speed_mps - a.speed_mps),
          a.accel_mps2 + rest * (b.accel_mps2 - a.accel_mps2)};
}

Place Route::placeAlong(double way_m) const {
  const double step = std::clamp(way_m / kStep_m, 0.0, static_cast<double>(path_.size() - 2));
  const auto i = static_cast<size_t>(step);
  const Vector3d at = path_[i] + (step - static_cast<double>(i)) * (path_[i + 1] - path_[i]);
  return {{at.x(), at.y(), 0}, at.z()};
}

Eigen::Isometry3d Route::bodyAt(double time_s) const {
  const State state = stateAt(time_s);
  const Place place = placeAlong(state.way_m);
  double pitch = 0, roll = 0, heave = 0;  // pitch: down is positive
  if (drive_.sways) {
    // Road roughness is a function of the distance, so a standing camera does not move.
    const double way = state.way_m;
    pitch = 0.0035 * noise2(way / 4.0, 0.5, seed_) + 0.0015 * noise2(way / 1.3, 0.5, seed_ + 1);
    pitch -= 0.0025 * state.accel_mps2;
    roll = 0.004 * noise2(way / 5.0, 0.5, seed_ + 2);
    heave = 0.012 * noise2(way / 3.0, 0.5, seed_ + 3);
  }
  const double look =
      drive_.look_deg * kPi / 180 * std::sin(2 * kPi * time_s / drive_.look_period_s);
  Eigen::Isometry3d T_world_vehicle = Eigen::Isometry3d::Identity();
  T_world_vehicle.linear() =
      (Eigen::AngleAxisd(place.heading_rad + look, Vector3d::UnitZ()) *
       Eigen::AngleAxisd(pitch, Vector3d::UnitY()) * Eigen::AngleAxisd(roll, Vector3d::UnitX()))
          .toRotationMatrix();
  T_world_vehicle.translation() = place.position_m + Vector3d(0, 0, heave);
  return T_world_vehicle;
}

}  // namespace predictive_stereo::simulation
