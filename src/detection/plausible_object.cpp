#include "detection/plausible_object.h"

#include <algorithm>

#include "detection/obstacles.h"

namespace predictive_stereo {
namespace {

constexpr double kSlope = 0.03;        // of the ground: a far object may be uphill
constexpr double kLeastVisible = 0.5;  // of the height of a partly hidden object
constexpr int kBelow = 3;              // rows of cells in which something nearer hides a lower end

}  // namespace

LowerEnd lowerEndOf(const DepthCells& cells, const std::optional<GroundPlane>& ground,
                    const cv::Rect& box, float nearest_px) {
  const cv::Mat1f& disparity_px = cells.disparity_px;
  const auto cellsUntil = [](int end_px) { return (end_px + kCellSide_px - 1) / kCellSide_px; };
  const int first = cellsUntil(box.br().y), end = std::min(first + kBelow, disparity_px.rows);
  if (first >= disparity_px.rows) return LowerEnd::kCut;
  if (!ground) return LowerEnd::kFoot;
  const int left = box.x / kCellSide_px,
            right = std::min(cellsUntil(box.br().x), disparity_px.cols);
  int hidden = 0;  // columns
  for (int u = left; u < right; ++u)
    for (int v = first; v < end; ++v) {
      const float d = disparity_px(v, u);
      if (d <= nearest_px || ground->heightOf({u, v}, d) <= kGroundMargin_m) continue;
      ++hidden;
      break;
    }
  return 2 * hidden > right - left ? LowerEnd::kHidden : LowerEnd::kFoot;
}

bool isPlausible(const MotionDetectionParams& params, const Extent& extent, LowerEnd lower_end,
                 double distance_m) {
  const double visible = lower_end == LowerEnd::kFoot     ? 1
                         : lower_end == LowerEnd::kHidden ? kLeastVisible
                                                          : 0;
  if (extent.width_m < params.min_width_m || extent.width_m > params.max_width_m ||
      extent.height_m < visible * params.min_height_m || extent.height_m > params.max_height_m)
    return false;
  if (lower_end == LowerEnd::kCut || !extent.above_ground) return true;
  const auto [foot_m, top_m] = *extent.above_ground;
  const double uphill_m = kSlope * distance_m;
  return top_m <= params.max_height_m + uphill_m &&
         (lower_end == LowerEnd::kHidden || foot_m <= params.max_foot_m + uphill_m);
}

}  // namespace predictive_stereo
