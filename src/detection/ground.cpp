#include "detection/ground.h"

#include <algorithm>
#include <vector>

namespace predictive_stereo {
namespace {

constexpr double kReach_m = 0.15;    // up and down, over which the disparity's growth is taken
constexpr int kMostReach = 4;        // in lattice rows
constexpr double kLeastShare = 0.5;  // of a level surface's growth; that of an upright one is 0
constexpr int kNearestRow_px = 4;    // below the horizon
constexpr double kThickness_m = 0.3;
constexpr size_t kFewest = 20;

}  // namespace

// On a level surface h below the camera d = B (y - y_horizon) / h, so d' = d / (y - y_horizon)
// whatever h is.
void levelGround(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px,
                 const cv::Rect& area, cv::Mat1b& ground) {
  ground.create(area.size());
  ground.setTo(0);
  std::vector<float> depths_m;  // below the camera
  cv::Mat1f below_m(area.size());
  for (int v = 0; v < area.height; ++v) {
    const int y = 2 * (area.y + v);
    const double under_horizon = y - rig.cy_px;
    if (under_horizon < kNearestRow_px) continue;
    for (int u = 0; u < area.width; ++u) {
      const int x = 2 * (area.x + u);
      const float d = disparity_px(y, x);
      if (!range.isValid(d) || !(d > 0)) continue;
      const double pixels = kReach_m * d / rig.baseline_m;
      const int reach = 2 * std::clamp(static_cast<int>(0.5 * pixels), 1, kMostReach);
      if (y < reach || y + reach >= disparity_px.rows) continue;
      const float above = disparity_px(y - reach, x), beneath = disparity_px(y + reach, x);
      if (!range.isValid(above) || !range.isValid(beneath)) continue;
      const double expected = 2 * reach * d / under_horizon;
      if (beneath - above < kLeastShare * expected || beneath - above > 2 * expected) continue;
      ground(v, u) = 255;
      below_m(v, u) = static_cast<float>(under_horizon * rig.baseline_m / d);
      depths_m.push_back(below_m(v, u));
    }
  }
  if (depths_m.size() < kFewest) {
    ground.setTo(0);
    return;
  }
  const auto low = depths_m.begin() + static_cast<std::ptrdiff_t>(0.8 * (depths_m.size() - 1));
  std::nth_element(depths_m.begin(), low, depths_m.end());
  const float least = *low - static_cast<float>(kThickness_m);
  for (int v = 0; v < area.height; ++v)
    for (int u = 0; u < area.width; ++u)
      if (ground(v, u) && below_m(v, u) < least) ground(v, u) = 0;
}

}  // namespace predictive_stereo
