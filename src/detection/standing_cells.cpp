#include "detection/standing_cells.h"

#include <cmath>

#include "detection/constants.h"

namespace predictive_stereo {

// The loops over rows have no branches, so that compilers vectorise them.

// The height of a cell is h (1 - expected / d): see GroundPlane::heightOf.
cv::Mat1b cellsAbove(const GroundPlane& ground, const DepthCells& cells) {
  const auto h = static_cast<float>(ground.camera_height_m);
  const auto per_column_px = static_cast<float>(kCellSide_px * ground.a);
  const auto margin_m = static_cast<float>(kGap_m);
  cv::Mat1b above(cells.disparity_px.size());
  const int columns = above.cols;
  for (int v = 0; v < above.rows; ++v) {
    const float* const disparity = cells.disparity_px[v];
    uchar* const of_row = above[v];
    const auto first_px =
        static_cast<float>(ground.disparityAt(kCellCentre_px, kCellSide_px * v + kCellCentre_px));
    for (int u = 0; u < columns; ++u) {
      const float d = disparity[u], expected = first_px + per_column_px * static_cast<float>(u);
      of_row[u] = ((d > 0) & (d * (h - margin_m) > expected * h)) ? 255 : 0;
    }
  }
  return above;
}

void addFeet(const GroundPlane& ground, const DepthCells& cells, cv::Mat1b& standing) {
  const float most_px = kLeastGrowth * kCellSide_px * static_cast<float>(ground.b);
  const int columns = standing.cols;
  for (int v = 1; v < standing.rows; ++v) {
    const float *const upper = cells.disparity_px[v - 1], *const lower = cells.disparity_px[v];
    const uchar* const above = standing[v - 1];
    uchar* const __restrict of_row = standing[v];
    for (int u = 0; u < columns; ++u) {
      const int is_upright = (lower[u] > 0) & (std::abs(lower[u] - upper[u]) < most_px);
      of_row[u] = static_cast<uchar>(of_row[u] | (above[u] & -is_upright));
    }
  }
}

// On a level surface at h below the camera d = B (y - y_horizon) / h, so d' = d / (y - y_horizon)
// for every h.
cv::Mat1b cellsNotLevel(const StereoRig& rig, const DepthCells& cells) {
  constexpr int kReach = 2;  // cells, up and down
  cv::Mat1b upright(cells.disparity_px.size());
  const int columns = upright.cols;
  for (int v = 0; v < upright.rows; ++v) {
    const auto below_horizon_px = static_cast<float>(kCellSide_px * v + kCellCentre_px - rig.cy_px);
    const bool can_tell = below_horizon_px > 0 && v >= kReach && v + kReach < upright.rows;
    const int reach = can_tell ? kReach : 0;  // without a reach the growth is 0
    const float *const upper = cells.disparity_px[v - reach], *const here = cells.disparity_px[v],
                       *const lower = cells.disparity_px[v + reach];
    uchar* const of_row = upright[v];
    for (int u = 0; u < columns; ++u) {
      const float level_px = 2 * kReach * kCellSide_px * here[u] / below_horizon_px;
      const float growth_px = lower[u] - upper[u];
      const bool is_level = (upper[u] > 0) & (growth_px >= kLeastGrowth * level_px) &
                            (growth_px <= kMostGrowth * level_px);
      of_row[u] = ((here[u] > 0) & !is_level) ? 255 : 0;
    }
  }
  return upright;
}

}  // namespace predictive_stereo
