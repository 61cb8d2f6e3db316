/// A rig for tests on maps of cells.
#pragma once

#include "detection/depth_cells.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

constexpr int kCellColumns = 60, kCellRows = 40;

inline StereoRig cellRig() {
  StereoRig rig;
  rig.size = {kCellSide_px * kCellColumns, kCellSide_px * kCellRows};
  rig.fx_px = rig.fy_px = 300;
  rig.cx_left_px = rig.cx_right_px = 120;
  rig.cy_px = 80;
  rig.baseline_m = 0.3;
  return rig;
}

/// Cells of which nothing is known.
inline DepthCells unknownCells(float variance_px2) {
  DepthCells cells;
  cells.disparity_px = cv::Mat1f(kCellRows, kCellColumns, 0.0f);
  cells.variance_px2 = cv::Mat1f(kCellRows, kCellColumns, variance_px2);
  cells.lattice_px = cv::Mat1f(2 * kCellRows, 2 * kCellColumns + 1, 0.0f);
  return cells;
}

}  // namespace predictive_stereo
