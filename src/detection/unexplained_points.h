#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/point_tracks.h"

namespace predictive_stereo {

constexpr int kPatchReach = 2;
constexpr size_t kMostSuspects = 3000;

/// Drops points that a static point explains after all, with a disparity a little larger or smaller
/// or one of those around: the disparities of foliage, fences and edges are often off by that. And
/// points that something nearer has just uncovered, as the previous frame does not show them.
/// @param seconds  between both frames.
/// @param points_px  on the lattice, at least kPatchReach lattice points from the border.
/// @param kept  the others, in their order. Where there are more than kMostSuspects points, as
/// where
///   ego-motion fails, only an even sample of them is looked at.
void unexplainedPoints(const TrackingView& view, const MotionDetectionParams& params,
                       double seconds, const std::vector<cv::Point>& points_px,
                       std::vector<cv::Point>& kept);

}  // namespace predictive_stereo
