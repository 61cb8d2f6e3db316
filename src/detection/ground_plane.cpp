#include "detection/ground_plane.h"

#include <Eigen/Dense>
#include <cmath>
#include <vector>

namespace predictive_stereo {
namespace {

constexpr size_t kMostSamples = 1500, kFewestSamples = 30;
constexpr int kMostTrials = 150, kFits = 5;
constexpr double kMayMiss = 1e-3;  // probability that no trial has three samples of the plane
constexpr uint64_t kSeed = 7;
constexpr double kLeastShare = 0.06;                      // of the known cells, on the plane
constexpr double kTolerance_px = 0.6, kTolerance = 0.02;  // of a disparity, and relative to it
constexpr double kLeastTriangle_px2 = 100;                // twice its area
const double kLeastCos = std::cos(80 * M_PI / 180), kMostSinRoll = std::sin(30 * M_PI / 180);

struct Sample {
  double x, y, d;
};

// An even sample of the known cells.
std::vector<Sample> samplesOf(const DepthCells& cells) {
  std::vector<Sample> all;
  for (int v = 0; v < cells.disparity_px.rows; ++v)
    for (int u = 0; u < cells.disparity_px.cols; ++u)
      if (const float d = cells.disparity_px(v, u); d > 0)
        all.push_back({double(kCellSide_px * u + kCellCentre_px),
                       double(kCellSide_px * v + kCellCentre_px), d});
  const size_t step = all.size() / kMostSamples + 1;
  std::vector<Sample> samples;
  for (size_t i = 0; i < all.size(); i += step) samples.push_back(all[i]);
  return samples;
}

std::optional<GroundPlane> planeOf(const StereoRig& rig, const Eigen::Vector3d& abc) {
  // fx B = a fx X + b fy Y + (d at the principal point) Z.
  const Eigen::Vector3d normal(abc[0] * rig.fx_px, abc[1] * rig.fy_px,
                               abc[0] * rig.cx_left_px + abc[1] * rig.cy_px + abc[2]);
  const double length = normal.norm();
  if (!(length > 0) || normal.y() < kLeastCos * length ||
      std::abs(normal.x()) > kMostSinRoll * length)
    return std::nullopt;
  return GroundPlane{abc[0], abc[1], abc[2], rig.disparityTimesDepth() / length};
}

double toleranceAt(double disparity_px) { return kTolerance_px + kTolerance * disparity_px; }

// Samples on the plane, minus those that are seen through it.
int scoreOf(const GroundPlane& plane, const std::vector<Sample>& samples, int& on_plane) {
  on_plane = 0;
  int below = 0;
  for (const Sample& s : samples) {
    const double expected = plane.disparityAt(s.x, s.y);
    if (!(expected > 0)) continue;
    const double tolerance = toleranceAt(expected);
    on_plane += std::abs(s.d - expected) < tolerance;
    below += s.d < expected - 2 * tolerance;
  }
  return on_plane - below;
}

// Trials until a plane with so many of the samples is found, but for kMayMiss.
int trialsFor(int on_plane, size_t samples) {
  const double share = on_plane / static_cast<double>(samples);
  const double trials = std::log(kMayMiss) / std::log1p(-share * share * share);
  return trials < kMostTrials ? static_cast<int>(trials) + 1 : kMostTrials;
}

std::optional<GroundPlane> fitTo(const StereoRig& rig, const std::vector<Sample>& samples,
                                 const GroundPlane& near) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Sample& s : samples) {
    const double expected = near.disparityAt(s.x, s.y);
    if (!(expected > 0) || std::abs(s.d - expected) > toleranceAt(expected)) continue;
    const Eigen::Vector3d row(s.x, s.y, 1);
    A += row * row.transpose();
    b += row * s.d;
  }
  return planeOf(rig, A.ldlt().solve(b));
}

}  // namespace

std::optional<GroundPlane> findGroundPlane(const StereoRig& rig, const DepthCells& cells,
                                           const std::optional<GroundPlane>& last) {
  const std::vector<Sample> samples = samplesOf(cells);
  if (samples.size() < kFewestSamples) return std::nullopt;
  std::optional<GroundPlane> best;
  int on_plane = 0, best_on_plane = 0, best_score = 0;
  const auto tryPlane = [&](std::optional<GroundPlane> plane) {
    if (!plane || scoreOf(*plane, samples, on_plane) <= best_score) return;
    // On a wall, a plane with an allowed slope can pass within the tolerance. The fits turn it to
    // the wall, whose slope is not allowed.
    for (int k = 0; k < kFits && plane; ++k) plane = fitTo(rig, samples, *plane);
    if (!plane) return;
    const int score = scoreOf(*plane, samples, on_plane);
    if (score <= best_score) return;
    best = plane;
    best_score = score;
    best_on_plane = on_plane;
  };
  tryPlane(last);
  cv::RNG random(kSeed);
  for (int trial = 0; trial < trialsFor(best_on_plane, samples.size()); ++trial) {
    Eigen::Matrix3d A;
    Eigen::Vector3d d;
    for (int k = 0; k < 3; ++k) {
      const Sample& s = samples[random.uniform(0, static_cast<int>(samples.size()))];
      A.row(k) << s.x, s.y, 1;
      d[k] = s.d;
    }
    if (std::abs(A.determinant()) < kLeastTriangle_px2) continue;
    tryPlane(planeOf(rig, A.inverse() * d));
  }
  if (!best || best_on_plane < kLeastShare * static_cast<double>(samples.size()))
    return std::nullopt;
  return best;
}

}  // namespace predictive_stereo
