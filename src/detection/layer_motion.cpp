#include "detection/layer_motion.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "detection/history_rows.h"

namespace predictive_stereo {
namespace {

using Eigen::Vector3d;

constexpr float kSigma_px = 0.5f, kSigmaPerDisparity = 0.015f;  // of the difference of two
// Of what is searched, and how far a step may carry points: across by this, along by one pixel of
// disparity.
constexpr double kFastestAcross_mps = 4, kFastestAlong_mps = 21, kStepAcross_m = 0.25;
constexpr double kFirstLook_s = 0.4;  // back: where motion shows and the search is not yet wide
constexpr int kHalvings = 2;
constexpr size_t kCandidates = 16;  // of the first look, that all frames are asked for
// Systematic errors of the place of a layer.
constexpr double kSigmaAcross_m = 0.25, kSigmaLayer_px = 0.25;
// Where motions explain the past equally well the slower one is taken: cost per m/s.
constexpr double kCostOfSpeed = 0.01;

constexpr float kUnknownCost = DisparityHistory::kMostCost / 2;

CostLimits limitsOf(const DisparityRange& range) {
  return {kSigma_px, kSigmaPerDisparity, DisparityHistory::kMostCost, kUnknownCost,
          static_cast<float>(range.min_disparity)};
}

PastDisparities disparitiesOf(const PastFrame& past, const SourceOf& source) {
  const cv::Mat1f& map = past.frame->disparity_px;
  return {source.H().data(), map[0], static_cast<int>(map.step1()), map.cols, map.rows};
}

}  // namespace

// Points, and room for what is found of each of them.
struct DisparityHistory::Points {
  std::vector<float> x, y, d, result;
  std::vector<uchar> known;

  void add(int px, int py, float disparity_px) {
    x.push_back(static_cast<float>(px));
    y.push_back(static_cast<float>(py));
    d.push_back(disparity_px);
  }
  void makeRoom() {
    result.resize(x.size());
    known.resize(x.size());
  }
  PointRow row() const { return {x.data(), y.data(), d.data(), static_cast<int>(x.size())}; }
};

DisparityHistory::DisparityHistory(const StereoRig& rig, const DisparityRange& range,
                                   const cv::Mat1f& disparity_px,
                                   const std::vector<PastFrame>& past)
    : rig_(rig), range_(range), disparity_px_(disparity_px), past_(past) {}

// What moves was farther back on its way then.
SourceOf DisparityHistory::sourceOf(const PastFrame& past, const Vector3d& velocity_mps) const {
  Eigen::Isometry3d T = past.T_past_cam;
  T.translation() -= T.linear() * velocity_mps * past.seconds;
  return SourceOf(disparityMotion(rig_, T));
}

double DisparityHistory::meanCost(const PastFrame& past, const Vector3d& velocity_mps,
                                  Points& points) const {
  const SourceOf source = sourceOf(past, velocity_mps);
  costRow(points.row(), disparitiesOf(past, source), limitsOf(range_), points.result.data());
  return std::accumulate(points.result.begin(), points.result.end(), 0.0f) /
         static_cast<double>(points.result.size());
}

std::optional<LayerMotion> DisparityHistory::fit(const std::vector<cv::Point>& points_px,
                                                 const std::optional<Vector3d>& expected) const {
  Points points;
  for (cv::Point p : points_px) points.add(p.x, p.y, disparity_px_(p));
  if (past_.empty() || points_px.empty()) return std::nullopt;
  points.makeRoom();
  const float sum = std::accumulate(points.d.begin(), points.d.end(), 0.0f);
  const double depth_m = rig_.disparityTimesDepth() * static_cast<double>(points.d.size()) / sum;
  const double along_m = depth_m * depth_m / rig_.disparityTimesDepth();

  // Every second frame is enough.
  std::vector<const PastFrame*> frames;
  for (size_t k = past_.size() % 2 ? 0 : 1; k < past_.size(); k += 2) frames.push_back(&past_[k]);
  const auto costOf = [&](const Vector3d& velocity) {
    double cost = 0;
    for (const PastFrame* past : frames) cost += meanCost(*past, velocity, points);
    return cost / static_cast<double>(frames.size());
  };

  Vector3d best = expected.value_or(Vector3d::Zero());
  const PastFrame* first = frames.front();
  for (const PastFrame* past : frames)
    if (past->seconds < 1.1 * kFirstLook_s) first = past;
  double step_x = kStepAcross_m / first->seconds, step_z = along_m / first->seconds;
  double cost = costOf(best);
  if (!expected) {
    std::vector<std::pair<double, Vector3d>> candidates;
    const int wide = static_cast<int>(kFastestAcross_mps / step_x);
    const int deep = static_cast<int>(std::ceil(kFastestAlong_mps / step_z));
    for (int k = -deep; k <= deep; ++k)
      for (int i = -wide; i <= wide; ++i) {
        const Vector3d velocity(i * step_x, 0, k * step_z);
        candidates.emplace_back(meanCost(*first, velocity, points) + kCostOfSpeed * velocity.norm(),
                                velocity);
      }
    const size_t tried = std::min(kCandidates, candidates.size());
    std::partial_sort(candidates.begin(), candidates.begin() + std::ptrdiff_t(tried),
                      candidates.end(),
                      [](const auto& a, const auto& b) { return a.first < b.first; });
    for (size_t k = 0; k < tried; ++k) {
      const double c = costOf(candidates[k].second);
      if (c + kCostOfSpeed * candidates[k].second.norm() < cost + kCostOfSpeed * best.norm())
        cost = c, best = candidates[k].second;
    }
  }
  for (int round = 0; round <= kHalvings; ++round) {
    const Vector3d centre = best;
    for (int k = -2; k <= 2; ++k)
      for (int i = -2; i <= 2; ++i) {
        if (i == 0 && k == 0) continue;
        const Vector3d velocity = centre + Vector3d(0.5 * i * step_x, 0, 0.5 * k * step_z);
        const double c = costOf(velocity);
        if (c + kCostOfSpeed * velocity.norm() < cost + kCostOfSpeed * best.norm())
          cost = c, best = velocity;
      }
    step_x *= 0.5;
    step_z *= 0.5;
  }
  LayerMotion motion;
  motion.velocity_mps = best;
  motion.cost = cost;
  int known = 0;
  for (const PastFrame* past : frames) {
    const SourceOf by_static = sourceOf(*past, Vector3d::Zero()), by_object = sourceOf(*past, best);
    gainRow(points.row(), by_static.H().data(), disparitiesOf(*past, by_object), limitsOf(range_),
            points.result.data(), points.known.data());
    for (size_t i = 0; i < points.known.size(); ++i) {
      if (!points.known[i]) continue;
      motion.gain += points.result[i];
      ++known;
    }
  }
  motion.known = static_cast<double>(known) / static_cast<double>(frames.size() * points.d.size());
  motion.gain /= std::max(known, 1);
  const double seconds = frames.back()->seconds;
  const double across = kSigmaAcross_m / seconds, along = kSigmaLayer_px * along_m / seconds;
  motion.covariance = Vector3d(across * across, across * across, along * along).asDiagonal();
  return motion;
}

void DisparityHistory::addGain(const cv::Rect& area, const Vector3d& velocity_mps, float weight,
                               cv::Mat1f& sum) const {
  CV_Assert(sum.size() == area.size());
  const CostLimits limits = limitsOf(range_);
  Points row;
  for (int u = 0; u < area.width; ++u) row.add(2 * (area.x + u), 0, 0);
  row.makeRoom();
  int frames = 0;
  for (size_t k = past_.size() % 2 ? 0 : 1; k < past_.size(); k += 2) ++frames;
  for (size_t k = past_.size() % 2 ? 0 : 1; k < past_.size(); k += 2) {
    const SourceOf by_static = sourceOf(past_[k], Vector3d::Zero());
    const SourceOf by_object = sourceOf(past_[k], velocity_mps);
    const PastDisparities then = disparitiesOf(past_[k], by_object);
    const float of_frame = weight / static_cast<float>(frames);
    for (int v = 0; v < area.height; ++v) {
      const int y = 2 * (area.y + v);
      const float* disparity = disparity_px_[y] + 2 * area.x;
      for (size_t u = 0; u < row.d.size(); ++u) row.d[u] = disparity[2 * u];
      std::fill(row.y.begin(), row.y.end(), static_cast<float>(y));
      gainRow(row.row(), by_static.H().data(), then, limits, row.result.data(), row.known.data());
      float* of_row = sum[v];
      for (size_t u = 0; u < row.d.size(); ++u)
        if (row.known[u] && range_.isValid(row.d[u])) of_row[u] += of_frame * row.result[u];
    }
  }
}

}  // namespace predictive_stereo
