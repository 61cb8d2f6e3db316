/// What stands on the ground, and what is the ground.
#pragma once

#include <opencv2/core.hpp>

#include "detection/depth_cells.h"
#include "detection/ground_plane.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// 255 on cells with a disparity more than kGap_m above the ground, 0 elsewhere.
cv::Mat1b cellsAbove(const GroundPlane& ground, const DepthCells& cells);

/// Adds the feet: cells below those that stand whose disparity is that of an upright surface.
/// @param[in,out] standing  255 or 0; of the size of the cells.
void addFeet(const GroundPlane& ground, const DepthCells& cells, cv::Mat1b& standing);

/// Where no plane of the ground is known: 255 on cells with a disparity, but 0 on those of surfaces
/// that are level at any height. The optical axis is assumed to be level; a camera that looks down
/// finds less of them.
cv::Mat1b cellsNotLevel(const StereoRig& rig, const DepthCells& cells);

}  // namespace predictive_stereo
