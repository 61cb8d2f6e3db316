#include "detection/ground_plane.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "detection/constants.h"

namespace predictive_stereo {
namespace {

constexpr size_t kMostSamples = 1500, kFewestSamples = 30;
constexpr int kMostTrials = 150, kFits = 5;
constexpr double kMayMiss = 1e-3;  // probability that no trial has three samples of the plane
constexpr uint64_t kSeed = 7;
constexpr double kLeastTriangle_px2 = 100;  // twice its area
const double kLeastCos = std::cos(kMostPitch_deg * M_PI / 180),
             kMostSinRoll = std::sin(kMostRoll_deg * M_PI / 180),
             kLeastCosTurned = std::cos(kMostTurn_deg * M_PI / 180);

struct Samples {
  std::vector<float> x_px, y_px, d_px;

  size_t size() const { return d_px.size(); }
  Eigen::Vector3d at(size_t i) const { return {x_px[i], y_px[i], d_px[i]}; }
};

// An even sample of the known cells.
Samples samplesOf(const DepthCells& cells) {
  const cv::Mat1f& map = cells.disparity_px;
  const size_t known = static_cast<size_t>(cv::countNonZero(map)), step = known / kMostSamples + 1;
  Samples samples;
  for (std::vector<float>* values : {&samples.x_px, &samples.y_px, &samples.d_px})
    values->reserve(known / step + 1);
  size_t skipped = step - 1;  // since the last sample
  for (int v = 0; v < map.rows; ++v)
    for (int u = 0; u < map.cols; ++u) {
      if (!(map(v, u) > 0)) continue;
      if (++skipped < step) continue;
      skipped = 0;
      samples.x_px.push_back(static_cast<float>(kCellSide_px * u + kCellCentre_px));
      samples.y_px.push_back(static_cast<float>(kCellSide_px * v + kCellCentre_px));
      samples.d_px.push_back(map(v, u));
    }
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
  return GroundPlane{abc[0], abc[1], abc[2], rig.disparityTimesDepth() / length, normal / length};
}

// Within which a disparity is that of the ground.
float toleranceAt(float disparity_px) { return kDisparitySigma_px + kScaleSigma * disparity_px; }

struct Score {
  int on_plane = 0;  // samples
  int value = 0;     // these, minus those that are seen through it
};

// Exact if its value is above `to_beat`. The lowest samples, which are often ground, come first.
// The inner loop has no branches, so that compilers vectorise it.
Score scoreOf(const GroundPlane& plane, const Samples& samples, int to_beat) {
  constexpr int kBlock = 128;
  const auto a = static_cast<float>(plane.a), b = static_cast<float>(plane.b),
             c = static_cast<float>(plane.c);
  const float *x = samples.x_px.data(), *y = samples.y_px.data(), *d = samples.d_px.data();
  int on_plane = 0, below = 0;
  for (int end = int(samples.size()); on_plane - below + end > to_beat && end > 0; end -= kBlock)
    for (int i = std::max(end - kBlock, 0); i < end; ++i) {
      const float expected = a * x[i] + b * y[i] + c, tolerance = toleranceAt(expected);
      const float above = d[i] - expected;
      const int exists = expected > 0 ? 1 : 0;
      on_plane += std::abs(above) < tolerance ? exists : 0;
      below += above < -2 * tolerance ? exists : 0;
    }
  return {on_plane, on_plane - below};
}

// Trials until a plane with so many of the samples is found, but for kMayMiss.
int trialsFor(int on_plane, size_t samples) {
  const double share = on_plane / static_cast<double>(samples);
  const double trials = std::log(kMayMiss) / std::log1p(-share * share * share);
  return trials < kMostTrials ? static_cast<int>(trials) + 1 : kMostTrials;
}

// Least squares over the samples on a plane.
std::optional<GroundPlane> fitTo(const StereoRig& rig, const Samples& samples,
                                 const GroundPlane& near) {
  const auto a = static_cast<float>(near.a), b = static_cast<float>(near.b),
             c = static_cast<float>(near.c);
  double n = 0, sx = 0, sy = 0, sd = 0, xx = 0, xy = 0, yy = 0, xd = 0, yd = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    const float expected = a * samples.x_px[i] + b * samples.y_px[i] + c;
    if (!(expected > 0) || std::abs(samples.d_px[i] - expected) > toleranceAt(expected)) continue;
    const double x = samples.x_px[i], y = samples.y_px[i], d = samples.d_px[i];
    n += 1, sx += x, sy += y, sd += d;
    xx += x * x, xy += x * y, yy += y * y, xd += x * d, yd += y * d;
  }
  Eigen::Matrix3d A;
  A << xx, xy, sx, xy, yy, sy, sx, sy, n;
  return planeOf(rig, A.ldlt().solve(Eigen::Vector3d(xd, yd, sd)));
}

// Whether an upright plane through the middle of its samples has nearly as many: they do not tell
// then whether it is a far wall.
bool mayBeUpright(const GroundPlane& plane, const Samples& samples, int on_plane) {
  double sum_y_px = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    const auto expected = static_cast<float>(plane.disparityAt(samples.x_px[i], samples.y_px[i]));
    if (expected > 0 && std::abs(samples.d_px[i] - expected) < toleranceAt(expected))
      sum_y_px += samples.y_px[i];
  }
  const GroundPlane wall{plane.a, 0, plane.b * sum_y_px / on_plane + plane.c};
  const int on_wall = scoreOf(wall, samples, -static_cast<int>(samples.size()) - 1).on_plane;
  return on_wall > kMostOnWall * on_plane;
}

bool areAlike(const GroundPlane& one, const GroundPlane& other) {
  return one.normal.dot(other.normal) > kLeastCosTurned &&
         std::abs(std::log(one.camera_height_m / other.camera_height_m)) < kMostHeightChange;
}

}  // namespace

std::optional<GroundPlane> findGroundPlane(const StereoRig& rig, const DepthCells& cells,
                                           const std::optional<GroundPlane>& last) {
  const Samples samples = samplesOf(cells);
  if (samples.size() < kFewestSamples) return std::nullopt;
  std::optional<GroundPlane> best;
  Score of_best;
  const auto tryPlane = [&](std::optional<GroundPlane> plane) {
    if (!plane || scoreOf(*plane, samples, of_best.value).value <= of_best.value) return;
    // On a wall, a plane with an allowed slope can pass within the tolerance. The fits turn it to
    // the wall, whose slope is not allowed.
    for (int k = 0; k < kFits && plane; ++k) plane = fitTo(rig, samples, *plane);
    if (!plane) return;
    const Score score = scoreOf(*plane, samples, of_best.value);
    if (score.value <= of_best.value) return;
    best = plane;
    of_best = score;
  };
  tryPlane(last);
  cv::RNG random(kSeed);
  for (int trial = 0; trial < trialsFor(of_best.on_plane, samples.size()); ++trial) {
    Eigen::Matrix3d A;
    Eigen::Vector3d d;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d sample =
          samples.at(static_cast<size_t>(random.uniform(0, static_cast<int>(samples.size()))));
      A.row(k) << sample.x(), sample.y(), 1;
      d[k] = sample.z();
    }
    if (std::abs(A.determinant()) < kLeastTriangle_px2) continue;
    tryPlane(planeOf(rig, A.inverse() * d));
  }
  if (!best) return std::nullopt;
  const double least_share =
      std::min(kGroundSharePerMetre * std::max(best->camera_height_m, 1.0), kMostGroundShare);
  if (of_best.on_plane < least_share * static_cast<double>(samples.size()) ||
      mayBeUpright(*best, samples, of_best.on_plane))
    return std::nullopt;
  return best;
}

void SteadyGround::setFrame(const StereoRig& rig, const DepthCells& cells) {
  const std::optional<GroundPlane> last = candidate_;
  candidate_ = findGroundPlane(rig, cells, last);
  plane_.reset();
  if (last && candidate_ && areAlike(*last, *candidate_)) plane_ = candidate_;
}

}  // namespace predictive_stereo
