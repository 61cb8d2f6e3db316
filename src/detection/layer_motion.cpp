#include "detection/layer_motion.h"

#include <algorithm>
#include <cmath>

namespace predictive_stereo {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

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

// The disparity that was measured there; negative: none.
float seenAt(const Vector3f& source, const cv::Mat1f& past_px, const DisparityRange& range) {
  const float x = source.x() + 0.5f, y = source.y() + 0.5f;
  if (!(source.z() > 0 && x >= 0 && y >= 0 && x < static_cast<float>(past_px.cols) &&
        y < static_cast<float>(past_px.rows)))
    return -1;
  const float seen = past_px(static_cast<int>(y), static_cast<int>(x));
  return range.isValid(seen) ? std::max(seen, 0.0f) : -1;
}

// In standard deviations; positive: something nearer was seen.
float errorOf(float expected_px, float seen_px) {
  return (seen_px - expected_px) / (kSigma_px + kSigmaPerDisparity * expected_px);
}

}  // namespace

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

float DisparityHistory::costAt(const Vector3f& source, const cv::Mat1f& past_px) const {
  const float seen = seenAt(source, past_px, range_);
  if (seen < 0) return kUnknownCost;
  const float error = errorOf(source.z(), seen);
  if (error * error < kMostCost) return error * error;
  return error > 0 ? kUnknownCost : kMostCost;
}

// What hid the place of a static point was the object itself where it has its disparity.
std::optional<float> DisparityHistory::gainAt(const Vector3f& static_source,
                                              const Vector3f& moved_source,
                                              const cv::Mat1f& past_px) const {
  const float by_object = costAt(moved_source, past_px);
  if (by_object == kUnknownCost) return std::nullopt;
  const float seen = seenAt(static_source, past_px, range_);
  if (seen < 0) return std::nullopt;
  const float error = errorOf(static_source.z(), seen);
  if (error * error < kMostCost) return error * error - by_object;
  const float of_object = errorOf(moved_source.z(), seen);
  if (error > 0 && of_object * of_object > kMostCost) return std::nullopt;
  return kMostCost - by_object;
}

double DisparityHistory::meanCost(const PastFrame& past, const Vector3d& velocity_mps,
                                  const std::vector<Vector3f>& points) const {
  const SourceOf source = sourceOf(past, velocity_mps);
  float sum = 0;
  for (const Vector3f& p : points)
    sum += costAt(source(p.x(), p.y(), p.z()), past.frame->disparity_px);
  return sum / static_cast<double>(points.size());
}

std::optional<LayerMotion> DisparityHistory::fit(const std::vector<cv::Point>& points_px,
                                                 const std::optional<Vector3d>& expected) const {
  std::vector<Vector3f> points;
  for (cv::Point p : points_px)
    points.emplace_back(static_cast<float>(p.x), static_cast<float>(p.y), disparity_px_(p));
  if (past_.empty() || points.empty()) return std::nullopt;
  float sum = 0;
  for (const Vector3f& p : points) sum += p.z();
  const double depth_m = rig_.disparityTimesDepth() * static_cast<double>(points.size()) / sum;
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
    for (const Vector3f& p : points)
      if (const auto gain = gainAt(by_static(p.x(), p.y(), p.z()), by_object(p.x(), p.y(), p.z()),
                                   past->frame->disparity_px)) {
        motion.gain += *gain;
        ++known;
      }
  }
  motion.known = static_cast<double>(known) / static_cast<double>(frames.size() * points.size());
  motion.gain /= std::max(known, 1);
  const double seconds = frames.back()->seconds;
  const double across = kSigmaAcross_m / seconds, along = kSigmaLayer_px * along_m / seconds;
  motion.covariance = Vector3d(across * across, across * across, along * along).asDiagonal();
  return motion;
}

void DisparityHistory::addGain(const cv::Rect& area, const Vector3d& velocity_mps, float weight,
                               cv::Mat1f& sum) const {
  CV_Assert(sum.size() == area.size());
  int frames = 0;
  for (size_t k = past_.size() % 2 ? 0 : 1; k < past_.size(); k += 2) ++frames;
  for (size_t k = past_.size() % 2 ? 0 : 1; k < past_.size(); k += 2) {
    const SourceOf by_static = sourceOf(past_[k], Vector3d::Zero());
    const SourceOf by_object = sourceOf(past_[k], velocity_mps);
    const cv::Mat1f& past_px = past_[k].frame->disparity_px;
    for (int v = 0; v < area.height; ++v)
      for (int u = 0; u < area.width; ++u) {
        const int x = 2 * (area.x + u), y = 2 * (area.y + v);
        const float d = disparity_px_(y, x);
        if (!range_.isValid(d)) continue;
        const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
        if (const auto gain = gainAt(by_static(fx, fy, d), by_object(fx, fy, d), past_px))
          sum(v, u) += weight / static_cast<float>(frames) * *gain;
      }
  }
}

}  // namespace predictive_stereo
