#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/frame_comparison.h"

namespace predictive_stereo {

/// Displacement of a group of points.
struct ShiftFound {
  cv::Point2f shift_px;  ///< relative to a static world
  float gain = 0;        ///< mismatch without shift / mismatch with this one
};

/// Largest search range to the left and right, in lattice points.
constexpr int kSearchReach = 40;

/// Displacement of a group of lattice points in the previous frame, relative to a static world, by
/// exhaustive search: for objects that move too far for Lucas-Kanade.
/// @param static_source  where static points were.
/// @param reach  search range to the left and right, in lattice points; at most kSearchReach.
/// @returns the shift with the lowest mean zero-mean difference; none if it is not much better than
///   the others around it.
std::optional<ShiftFound> searchShift(const ImagePyramid& current, const ImagePyramid& previous,
                                      const SourceOf& static_source, const cv::Mat1f& disparity_px,
                                      const std::vector<cv::Point>& points,
                                      int reach = kSearchReach);

}  // namespace predictive_stereo
