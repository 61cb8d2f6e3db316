#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// 255 on lattice points that lie on level ground: where the disparity grows from row to row as on
/// a level surface, and as low as most of these surfaces in `area` do, so that bonnets and steps
/// are left out. The optical axis is taken as level; of a camera that looks down, less is found.
/// @param area  of the lattice of every second pixel and row.
/// @param ground  of the area's size.
void levelGround(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px,
                 const cv::Rect& area, cv::Mat1b& ground);

}  // namespace predictive_stereo
