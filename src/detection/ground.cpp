#include "detection/ground.h"

#include <algorithm>
#include <limits>

#include "detection/ground_rows.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr double kReach_m = 0.15;    // up and down, to measure the growth of the disparity
constexpr double kLeastShare = 0.5;  // of a level surface's growth; an upright surface has 0
constexpr double kMostShare = 2;
constexpr int kNearestRow_px = 4;  // below the horizon
constexpr double kThickness_m = 0.3;
constexpr size_t kFewest = 20;

}  // namespace

// On a level surface at h below the camera d = B (y - y_horizon) / h, so d' = d / (y - y_horizon)
// for every h.
void LevelGround::setFrame(const StereoRig& rig, const DisparityRange& range,
                           const cv::Mat1f& disparity_px) {
  below_m_.create((disparity_px.rows + 1) / 2, (disparity_px.cols + 1) / 2);
  parallelForEach(below_m_.rows, [&](int v) {
    const double under_horizon_px = 2 * v - rig.cy_px;
    if (under_horizon_px < kNearestRow_px) {
      std::fill_n(below_m_[v], below_m_.cols, 0.0f);
      return;
    }
    const float *above[kMostGroundReach], *beneath[kMostGroundReach];
    for (int k = 0; k < kMostGroundReach; ++k) {
      const int upper = 2 * (v - k - 1), lower = 2 * (v + k + 1);
      above[k] = upper >= 0 ? disparity_px[upper] : nullptr;
      beneath[k] = lower < disparity_px.rows ? disparity_px[lower] : nullptr;
    }
    const GroundLimits limits{static_cast<float>(range.min_disparity),
                              static_cast<float>(0.5 * kReach_m / rig.baseline_m),
                              static_cast<float>(under_horizon_px),
                              static_cast<float>(rig.baseline_m),
                              static_cast<float>(kLeastShare),
                              static_cast<float>(kMostShare)};
    levelRow(disparity_px[2 * v], above, beneath, below_m_.cols, limits, below_m_[v]);
  });
}

float LevelGround::lowestIn(const cv::Rect& area, Scratch<float>& work) const {
  if (area.empty()) return std::numeric_limits<float>::infinity();
  cv::Mat1f values = work.map(area.size());
  float* const first = values[0];
  size_t count = 0;
  for (int v = 0; v < area.height; ++v) {
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

}  // namespace predictive_stereo
