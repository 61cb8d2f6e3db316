#include "detection/joined_parts.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "detection/object_shape.h"

namespace predictive_stereo {
namespace {

constexpr double kGap_m = 2.5;           // between two parts
constexpr double kDepthSigmas_px = 0.6;  // two standard deviations of a part's disparity
constexpr float kFarther_px = 1.5f;      // is behind both
constexpr double kMostFarther = 0.2;     // of the line between them
constexpr double kSpeed_mps = 1, kSpeedShare = 0.1, kMostSigmas = 3;  // velocities differ by less

bool moveAlike(const Observation& a, const Observation& b) {
  if (!a.has_velocity || !b.has_velocity) return false;
  const Eigen::Vector3d difference = a.velocity_mps - b.velocity_mps;
  const double speed = std::max(a.velocity_mps.norm(), b.velocity_mps.norm());
  if (difference.norm() > kSpeed_mps + kSpeedShare * speed) return false;
  const Eigen::Matrix3d covariance = a.velocity_covariance + b.velocity_covariance;
  return difference.dot(covariance.inverse() * difference) < kMostSigmas * kMostSigmas;
}

double farEnd(const Observation& seen) { return seen.distance_m + seen.size_m.z(); }

// How far apart two intervals are; negative where they overlap.
double gapOf(double first_a, double last_a, double first_b, double last_b) {
  return std::max(first_a - last_b, first_b - last_a);
}

bool areNear(const StereoRig& rig, const Observation& a, const Observation& b) {
  const double nearest_m = std::min(a.distance_m, b.distance_m);
  const double error_m = kDepthSigmas_px * nearest_m * nearest_m / rig.disparityTimesDepth();
  if (gapOf(a.distance_m, farEnd(a), b.distance_m, farEnd(b)) > kGap_m + error_m) return false;
  const double gap_px = kGap_m * rig.fx_px / nearest_m;
  return gapOf(a.box_px.x, a.box_px.br().x, b.box_px.x, b.box_px.br().x) <= gap_px &&
         gapOf(a.box_px.y, a.box_px.br().y, b.box_px.y, b.box_px.br().y) <= gap_px;
}

cv::Point2d centreOf(const cv::Rect& box) {
  return {box.x + 0.5 * box.width, box.y + 0.5 * box.height};
}

// Whether the line between them shows nothing that is behind both: they have one surface, or
// something hides what is between.
bool areConnected(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px,
                  const Observation& a, const Observation& b) {
  const auto farthest_px =
      static_cast<float>(rig.disparityTimesDepth() / std::max(farEnd(a), farEnd(b)));
  const cv::Point2d from = centreOf(a.box_px), way = centreOf(b.box_px) - from;
  const int steps = static_cast<int>(std::hypot(way.x, way.y)) + 1;
  int farther = 0, between = 0;
  for (int i = 0; i <= steps; ++i) {
    const cv::Point at(from + way * (static_cast<double>(i) / steps));
    if (a.box_px.contains(at) || b.box_px.contains(at)) continue;
    ++between;
    const float d = disparity_px(at);
    farther += range.isValid(d) && d < farthest_px - kFarther_px;
  }
  return farther <= kMostFarther * between;
}

ObservedObject unionOf(const ObservedObject& a, const ObservedObject& b) {
  const cv::Rect &box_a = a.observation.box_px, &box_b = b.observation.box_px;
  const cv::Rect box = box_a | box_b;
  ObservedObject all;
  all.observation = (box_a.area() >= box_b.area() ? a : b).observation;
  all.observation.box_px = box;
  all.mask = cv::Mat1b::zeros(box.size());
  all.mask(box_a - box.tl()).setTo(255, a.mask);
  all.mask(box_b - box.tl()).setTo(255, b.mask);
  return all;
}

}  // namespace

void joinParts(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px,
               double max_width_m, std::vector<ObservedObject>& objects) {
  const auto joined = [&](const ObservedObject& a,
                          const ObservedObject& b) -> std::optional<ObservedObject> {
    if (!moveAlike(a.observation, b.observation) || !areNear(rig, a.observation, b.observation) ||
        !areConnected(rig, range, disparity_px, a.observation, b.observation))
      return std::nullopt;
    ObservedObject all = unionOf(a, b);
    Observation& seen = all.observation;
    const auto shape = shapeOf(rig, range, disparity_px, seen.box_px, all.mask);
    if (!shape || shape->size_m.x() > max_width_m) return std::nullopt;
    seen.centre_m = shape->centre_m;
    seen.size_m = shape->size_m;
    seen.distance_m = shape->distance_m;
    return all;
  };
  for (size_t i = 0; i < objects.size(); ++i)
    for (size_t k = i + 1; k < objects.size();) {
      auto all = joined(objects[i], objects[k]);
      if (!all) {
        ++k;
        continue;
      }
      objects[i] = std::move(*all);
      objects.erase(objects.begin() + static_cast<std::ptrdiff_t>(k));
      k = i + 1;  // what is larger now may reach others
    }
}

}  // namespace predictive_stereo
