/// Obstacles: depth-connected surfaces above the ground.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/depth_cells.h"
#include "detection/ground_plane.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// Obstacles of one frame.
struct Obstacles {
  cv::Mat1i number;        ///< of each cell's obstacle, from 0 on; -1: none
  std::vector<int> sizes;  ///< of each obstacle [cells]
  /// 255 on lattice points in cells that stand on the ground, with their feet; 0 on the ground and
  /// in cells without a disparity. Points beyond the last cell are as those beside them.
  cv::Mat1b standing;

  /// The cells of one obstacle, row by row. Lists of all of them would take longer to make.
  std::vector<cv::Point> cellsOf(int obstacle) const;
};

/// Joins neighbouring cells if there is certainly no step in depth between them, over gaps of one
/// unknown cell.
/// @param ground  cells on it, up to kGap_m above, are left out; none: those of level
///   surfaces are.
/// @param camera_pixel_px  side of a pixel of the camera: what the matcher does not tell apart.
Obstacles findObstacles(const StereoRig& rig, const DepthCells& cells,
                        const std::optional<GroundPlane>& ground, float camera_pixel_px = 1);

/// For each cell the width [px] of its obstacle at its thickest place: the largest square in it.
/// Large for cells of no obstacle, such as the ground. An obstacle ends where a farther surface
/// begins, not where a nearer one hides it.
cv::Mat1f obstacleWidths(const Obstacles& obstacles, const DepthCells& cells);

}  // namespace predictive_stereo
