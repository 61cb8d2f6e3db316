#include "evaluation/simulation/path.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "evaluation/simulation/noise.h"
#include "evaluation/simulation/route.h"

namespace predictive_stereo::simulation {
namespace {

constexpr double kRadPerDeg = 3.14159265358979 / 180;
constexpr double kFade_s = 0.4;  // a shake fades in and out in this time

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

Eigen::Isometry3d WaypointPath::bodyAt(double time_s) const {
  const Coordinates c = smoothAt(time_s) + shakeAt(time_s);
  Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
  T_world_body.linear() = (Eigen::AngleAxisd(c[3], Eigen::Vector3d::UnitZ()) *
                           Eigen::AngleAxisd(c[4], Eigen::Vector3d::UnitY()) *
                           Eigen::AngleAxisd(c[5], Eigen::Vector3d::UnitX()))
                              .toRotationMatrix();
  T_world_body.translation() = c.head<3>();
  return T_world_body;
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
