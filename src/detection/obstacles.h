/// Obstacles: depth-connected surfaces above the ground.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/depth_cells.h"
#include "detection/ground_plane.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

struct Obstacle {
  std::vector<cv::Point> cells;  ///< row by row
  cv::Rect area;                 ///< of these cells
};

/// Joins neighbouring cells without a step in depth between them, over gaps of one unknown cell.
/// Cells with a disparity that the rig measures at more than 60 m are left out.
/// @param ground  cells on it, up to kGroundMargin_m above, are left out; none: no cell is.
std::vector<Obstacle> findObstacles(const StereoRig& rig, const DepthCells& cells,
                                    const std::optional<GroundPlane>& ground);
constexpr double kGroundMargin_m = 0.25;

/// For each cell the width [px] of its obstacle at its thickest place: the largest square in it.
/// Large for cells of no obstacle, such as the ground. An obstacle ends where a farther surface
/// begins, not where a nearer one hides it.
cv::Mat1f obstacleWidths(const std::vector<Obstacle>& obstacles, const DepthCells& cells);

}  // namespace predictive_stereo
