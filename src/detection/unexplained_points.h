#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/frame_view.h"

namespace predictive_stereo {

constexpr int kPatchReach = 2;
constexpr size_t kMostSuspects = 3000;

/// Drops points that a static world explains after all, with a slightly larger or smaller disparity
/// or with that of a neighbour: disparities of foliage, fences and edges are often wrong by this.
/// Also drops points that were occluded in the previous frame.
/// @param points_px  on the lattice, at least kPatchReach lattice points from the border.
/// @param kept  the other points, in their order. If there are more than kMostSuspects points, as
///   when ego-motion fails, only an even sample of them is used.
void unexplainedPoints(const PastView& view, const std::vector<cv::Point>& points_px,
                       std::vector<cv::Point>& kept);

}  // namespace predictive_stereo
