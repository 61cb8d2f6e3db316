#include "detection/level_ground.h"

#include <algorithm>
#include <limits>

#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/level_ground.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef PREDICTIVE_STEREO_LEVEL_ROW
#define PREDICTIVE_STEREO_LEVEL_ROW
namespace predictive_stereo {

// Disparities are compared over 1, ..., kMostGroundReach lattice rows up and down.
constexpr int kMostGroundReach = 4;
constexpr float kLeastShare = 0.5f;  // of a level surface's growth; an upright surface has 0
constexpr float kMostShare = 2;

struct GroundLimits {
  float smallest_px;          // smallest valid disparity; only those above 0 are used
  float reach_by_disparity;   // [lattice rows / px]
  float horizon_distance_px;  // of the row, positive below
  float baseline_m;
  float reachable;  // lattice rows inside the map, both up and down
};

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

// Distance of a row's points below the camera [m] if the disparity grows as on a level surface; 0
// elsewhere.
// @param above, beneath  rows at distances 1, ... from it; any rows where limits.reachable ends.
//   Every second float of all rows is used.
HWY_NOINLINE void levelRow(const float* HWY_RESTRICT disparity_px,
                           const float* const above[kMostGroundReach],
                           const float* const beneath[kMostGroundReach], int width,
                           const GroundLimits& limits, float* HWY_RESTRICT below_m) {
  static_assert(kMostGroundReach == 4, "written out");
  const float *a1 = above[0], *a2 = above[1], *a3 = above[2], *a4 = above[3];
  const float *b1 = beneath[0], *b2 = beneath[1], *b3 = beneath[2], *b4 = beneath[3];
  const float reachable = limits.reachable;
  const float smallest = limits.smallest_px, by_disparity = limits.reach_by_disparity,
              horizon = limits.horizon_distance_px, baseline = limits.baseline_m;
  for (int u = 0; u < width; ++u) {
    const float d = disparity_px[2 * u];
    const float rows = by_disparity * d;
    const bool two = rows >= 2, three = rows >= 3, four = rows >= 4;
    const float upper1 = a1[2 * u], upper2 = a2[2 * u], upper3 = a3[2 * u], upper4 = a4[2 * u];
    const float lower1 = b1[2 * u], lower2 = b2[2 * u], lower3 = b3[2 * u], lower4 = b4[2 * u];
    float reach = two ? 2.0f : 1.0f, upper = two ? upper2 : upper1, lower = two ? lower2 : lower1;
    reach = three ? 3.0f : reach, upper = three ? upper3 : upper, lower = three ? lower3 : lower;
    reach = four ? 4.0f : reach, upper = four ? upper4 : upper, lower = four ? lower4 : lower;
    const float expected = 4 * reach * d / horizon;
    const float growth = lower - upper;
    const bool level = (reach <= reachable) & (d >= smallest) & (d > 0) & (upper >= smallest) &
                       (lower >= smallest) & (growth >= kLeastShare * expected) &
                       (growth <= kMostShare * expected);
    below_m[u] = level ? horizon * baseline / d : 0.0f;
  }
}

// 255 on points whose disparity is in the layer and that are less than `lowest_m` below the camera.
HWY_NOINLINE void layerRow(const float* HWY_RESTRICT disparity_px,
                           const float* HWY_RESTRICT below_m, int width, float farthest_px,
                           float nearest_px, float lowest_m, uint8_t* HWY_RESTRICT layer) {
  for (int u = 0; u < width; ++u) {
    const float d = disparity_px[2 * u];
    const int32_t inside = (d >= farthest_px) & (d <= nearest_px) & (below_m[u] < lowest_m);
    layer[u] = static_cast<uint8_t>(-inside);
  }
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(levelRow);
HWY_EXPORT(layerRow);

constexpr double kReach_m = 0.15;  // up and down, to measure the growth of the disparity
constexpr int kNearestRow_px = 4;  // below the horizon
constexpr double kThickness_m = 0.3;
constexpr size_t kFewest = 20;

}  // namespace

// On a level surface at h below the camera d = B (y - y_horizon) / h, so d' = d / (y - y_horizon)
// for every h.
void LevelGround::setFrame(const StereoRig& rig, const DisparityRange& range,
                           const cv::Mat1f& disparity_px) {
  below_m_.create((disparity_px.rows + 1) / 2, (disparity_px.cols + 1) / 2);
  first_row_ = 0;
  while (first_row_ < below_m_.rows && 2 * first_row_ - rig.cy_px < kNearestRow_px) ++first_row_;
  below_m_.rowRange(0, first_row_).setTo(0);
  parallelForEach(below_m_.rows - first_row_, [&](int i) {
    const int v = first_row_ + i;
    const int reachable = std::min({kMostGroundReach, v, below_m_.rows - 1 - v});
    const float *above[kMostGroundReach], *beneath[kMostGroundReach];
    for (int k = 0; k < kMostGroundReach; ++k) {
      const int step = k < reachable ? k + 1 : 0;
      above[k] = disparity_px[2 * (v - step)];
      beneath[k] = disparity_px[2 * (v + step)];
    }
    const GroundLimits limits{static_cast<float>(range.min_disparity),
                              static_cast<float>(0.5 * kReach_m / rig.baseline_m),
                              static_cast<float>(2 * v - rig.cy_px),
                              static_cast<float>(rig.baseline_m), static_cast<float>(reachable)};
    HWY_DYNAMIC_DISPATCH(levelRow)
    (disparity_px[2 * v], above, beneath, below_m_.cols, limits, below_m_[v]);
  });
}

// Distance below the camera [m] from which on level surfaces in `area` are ground; infinity if
// there are none.
float LevelGround::lowestIn(const cv::Rect& area) const {
  if (area.empty()) return std::numeric_limits<float>::infinity();
  cv::AutoBuffer<float> values(static_cast<size_t>(area.area()));
  float* const first = values.data();
  size_t count = 0;
  for (int v = std::max(first_row_ - area.y, 0); v < area.height; ++v) {
    const float* row = below_m_[area.y + v] + area.x;
    for (int u = 0; u < area.width; ++u) {
      first[count] = row[u];
      count += row[u] > 0;
    }
  }
  if (count < kFewest) return std::numeric_limits<float>::infinity();
  float* const low = first + static_cast<std::ptrdiff_t>(0.8 * static_cast<double>(count - 1));
  std::nth_element(first, low, first + count);
  return std::max(*low - static_cast<float>(kThickness_m), 1e-6f);
}

cv::Mat1b LevelGround::layerIn(const cv::Rect& area, const cv::Mat1f& disparity_px,
                               float farthest_px, float nearest_px) const {
  const float lowest_m = lowestIn(area);
  cv::Mat1b layer(area.size());
  for (int v = 0; v < area.height; ++v) {
    const int row = area.y + v;
    HWY_DYNAMIC_DISPATCH(layerRow)
    (disparity_px[2 * row] + 2 * area.x, below_m_[row] + area.x, area.width, farthest_px,
     nearest_px, lowest_m, layer[v]);
  }
  return layer;
}

}  // namespace predictive_stereo
#endif
