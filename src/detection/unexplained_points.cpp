#include "detection/unexplained_points.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "detection/patch_rows.h"
#include "detection/suspicion.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

static_assert(2 * kPatchReach + 1 == GreyPatch::kSide);
constexpr int kAround_px = 4;               // distance of the neighbours whose disparity is tried
constexpr float kDisparityError_px = 1.0f;  // of the point's own disparity
constexpr float kSameDisparity_px = 0.5f;
constexpr double kFastestAway_mps = 30;  // of an object that moves along the line of sight
constexpr float kHidingMargin_px = 1.0f;

// Whether a static point was occluded in the past frame: at its position there was a surface so
// much nearer that it cannot be the same one, even if it moves with the camera.
bool wasHidden(const PastView& view, cv::Point pixel, float disparity_px) {
  const cv::Mat1f& past_px = view.past.frame->disparity_px;
  const Eigen::Vector3f from =
      view.static_source(static_cast<float>(pixel.x), static_cast<float>(pixel.y), disparity_px);
  const int x = cvRound(from.x()), y = cvRound(from.y());
  if (!(from.z() > 0) || x < 0 || y < 0 || x >= past_px.cols || y >= past_px.rows) return false;
  const auto disparity_times_depth = static_cast<float>(view.rig().disparityTimesDepth());
  const auto nearer_m = static_cast<float>(kFastestAway_mps * view.past.seconds);
  const float before = past_px(y, x);
  const float hiding_m = disparity_times_depth / from.z() - nearer_m;
  return view.isKnown(before) && before > from.z() + kHidingMargin_px &&
         before * hiding_m > disparity_times_depth;
}

// Bytes of a patch at a sub-pixel position, copied if a read would leave the image.
struct PatchBytes {
  const uint8_t* upper_left;
  std::ptrdiff_t stride;
  uint8_t copy[kPatchRows * kPatchColumns];

  PatchBytes(const cv::Mat1b& image, int column, int row)
      : upper_left(image[row] + column), stride(static_cast<std::ptrdiff_t>(image.step)) {
    if (column + kPatchColumns <= image.cols && row + kPatchRows <= image.rows) return;
    for (int v = 0; v < kPatchRows; ++v)
      for (int u = 0; u < kPatchColumns; ++u)
        copy[kPatchColumns * v + u] =
            image(std::min(row + v, image.rows - 1), std::min(column + u, image.cols - 1));
    upper_left = copy;
    stride = kPatchColumns;
  }
  PatchBytes(const PatchBytes&) = delete;
};

bool isExplained(const PastView& view, cv::Point p) {
  const float own = view.disparity_px()(p);
  const PatchBytes here(view.images().level(1), p.x / 2 - kPatchReach, p.y / 2 - kPatchReach);
  GreyPatch now;
  patchBetween(here.upper_left, here.stride, 0, 0, now);
  const float most =
      static_cast<float>(view.params().min_mismatch) * (patchTexture(now) + Suspicion::kGreyNoise);
  const cv::Mat1b& previous = view.past_images().level(1);
  const auto end_x = static_cast<float>(previous.cols - kPatchReach - 1),
             end_y = static_cast<float>(previous.rows - kPatchReach - 1);
  const auto explains = [&](float disparity) {
    const Eigen::Vector3f from =
        view.static_source(static_cast<float>(p.x), static_cast<float>(p.y), disparity);
    const float x = 0.5f * from.x(), y = 0.5f * from.y();
    if (!(x >= kPatchReach && y >= kPatchReach && x < end_x && y < end_y)) return false;
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const PatchBytes then(previous, column - kPatchReach, row - kPatchReach);
    return patchDifference(now, then.upper_left, then.stride, x - static_cast<float>(column),
                           y - static_cast<float>(row)) < most;
  };
  for (float error : {0.0f, kDisparityError_px, -kDisparityError_px})
    if (own + error > 0 && explains(own + error)) return true;
  for (int dy = -kAround_px; dy <= kAround_px; dy += kAround_px)
    for (int dx = -kAround_px; dx <= kAround_px; dx += kAround_px) {
      const float other = view.disparity_px()(p.y + dy, p.x + dx);
      if (view.isKnown(other) && other > 0 && std::abs(other - own) > kSameDisparity_px &&
          explains(other))
        return true;
    }
  return false;
}

}  // namespace

void unexplainedPoints(const PastView& view, const std::vector<cv::Point>& points_px,
                       std::vector<cv::Point>& kept) {
  const size_t step = (points_px.size() + kMostSuspects - 1) / kMostSuspects;
  std::vector<uint8_t> unexplained(step ? (points_px.size() + step - 1) / step : 0);
  parallelForEach(static_cast<int>(unexplained.size()), [&](int i) {
    const cv::Point p = points_px[step * static_cast<size_t>(i)];
    const float d = view.disparity_px()(p);
    unexplained[static_cast<size_t>(i)] =
        view.isKnown(d) && d > 0 && !wasHidden(view, p, d) && !isExplained(view, p);
  });
  kept.clear();
  for (size_t i = 0; i < unexplained.size(); ++i)
    if (unexplained[i]) kept.push_back(points_px[step * i]);
}

}  // namespace predictive_stereo
