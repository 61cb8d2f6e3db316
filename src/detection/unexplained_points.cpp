#include "detection/unexplained_points.h"

#include <array>
#include <cmath>
#include <cstdint>

#include "detection/frame_comparison.h"
#include "detection/suspicion.h"

namespace predictive_stereo {
namespace {

constexpr int kSide = 2 * kPatchReach + 1, kArea = kSide * kSide;
constexpr int kAround_px = 4;               // how far away another disparity may be taken from
constexpr float kDisparityError_px = 1.0f;  // of the point's own disparity
constexpr float kSameDisparity_px = 0.5f;

/// Grey values of lattice points after their mean is taken away.
struct Patch {
  std::array<float, kArea> grey;

  void removeMean() {
    float sum = 0;
    for (float g : grey) sum += g;
    for (float& g : grey) g -= sum / kArea;
  }
  float texture() const {
    float sum = 0;
    for (float g : grey) sum += std::abs(g);
    return sum / kArea;
  }
};

Patch patchAt(const cv::Mat1b& image, cv::Point at) {
  Patch patch;
  for (int dy = 0; dy < kSide; ++dy)
    for (int dx = 0; dx < kSide; ++dx)
      patch.grey[static_cast<size_t>(kSide * dy + dx)] =
          image(at.y + dy - kPatchReach, at.x + dx - kPatchReach);
  patch.removeMean();
  return patch;
}

// Between four points; false where it is cut by the border.
bool patchBetween(const cv::Mat1b& image, float x, float y, Patch& patch) {
  const bool inside = x >= kPatchReach && y >= kPatchReach &&
                      x < static_cast<float>(image.cols - kPatchReach - 1) &&
                      y < static_cast<float>(image.rows - kPatchReach - 1);
  if (!inside) return false;
  const int column = static_cast<int>(x), line = static_cast<int>(y);
  const float fx = x - static_cast<float>(column), fy = y - static_cast<float>(line);
  for (int dy = 0; dy < kSide; ++dy) {
    const uchar* upper = image[line + dy - kPatchReach] + column - kPatchReach;
    const uchar* lower = image[line + dy - kPatchReach + 1] + column - kPatchReach;
    for (int dx = 0; dx < kSide; ++dx) {
      const float top = upper[dx] + fx * static_cast<float>(upper[dx + 1] - upper[dx]);
      const float bottom = lower[dx] + fx * static_cast<float>(lower[dx + 1] - lower[dx]);
      patch.grey[static_cast<size_t>(kSide * dy + dx)] = top + fy * (bottom - top);
    }
  }
  patch.removeMean();
  return true;
}

float meanDifference(const Patch& a, const Patch& b) {
  float sum = 0;
  for (size_t i = 0; i < kArea; ++i) sum += std::abs(a.grey[i] - b.grey[i]);
  return sum / kArea;
}

bool isExplained(const TrackingView& view, const SourceOf& static_source, float min_mismatch,
                 cv::Point p) {
  const float own = view.disparity_px(p);
  const Patch now = patchAt(view.current.level(1), p / 2);
  const float most = min_mismatch * (now.texture() + Suspicion::kGreyNoise);
  Patch before;
  const auto explains = [&](float disparity) {
    const Eigen::Vector3f from =
        static_source(static_cast<float>(p.x), static_cast<float>(p.y), disparity);
    return patchBetween(view.previous.pyramid.level(1), 0.5f * from.x(), 0.5f * from.y(), before) &&
           meanDifference(now, before) < most;
  };
  for (float error : {0.0f, kDisparityError_px, -kDisparityError_px})
    if (own + error > 0 && explains(own + error)) return true;
  for (int dy = -kAround_px; dy <= kAround_px; dy += kAround_px)
    for (int dx = -kAround_px; dx <= kAround_px; dx += kAround_px) {
      const float other = view.disparity_px(p.y + dy, p.x + dx);
      if (view.range.isValid(other) && other > 0 && std::abs(other - own) > kSameDisparity_px &&
          explains(other))
        return true;
    }
  return false;
}

}  // namespace

void unexplainedPoints(const TrackingView& view, const MotionDetectionParams& params,
                       double seconds, const std::vector<cv::Point>& points_px,
                       std::vector<cv::Point>& kept) {
  const SourceOf static_source(disparityMotion(view.rig, view.T_prev_cam));
  const auto min_mismatch = static_cast<float>(params.min_mismatch);
  const Uncovered uncovered(view.rig, static_source, view.previous.disparity_px, seconds);
  const size_t step = (points_px.size() + kMostSuspects - 1) / kMostSuspects;
  std::vector<uint8_t> unexplained(step ? (points_px.size() + step - 1) / step : 0);
  const cv::Range all(0, static_cast<int>(unexplained.size()));
  cv::parallel_for_(all, [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      const cv::Point p = points_px[step * static_cast<size_t>(i)];
      const float d = view.disparity_px(p);
      unexplained[static_cast<size_t>(i)] = view.range.isValid(d) && d > 0 && !uncovered(p, d) &&
                                            !isExplained(view, static_source, min_mismatch, p);
    }
  });
  kept.clear();
  for (size_t i = 0; i < unexplained.size(); ++i)
    if (unexplained[i]) kept.push_back(points_px[step * i]);
}

}  // namespace predictive_stereo
