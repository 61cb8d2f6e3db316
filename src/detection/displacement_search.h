#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/frame_comparison.h"

namespace predictive_stereo {

/// Where a group of points was found.
struct ShiftFound {
  cv::Point2f shift_px;  ///< from where the static world puts it
  float gain = 0;        ///< mismatch of no shift by that of this one
};

/// Points of the lattice by which a group is looked for to the left and right, at most.
constexpr int kSearchReach = 40;

/// Where a group of lattice points as a whole was in the previous frame, against where the static
/// world puts it: found by trying all shifts, for what moves too far for Lucas-Kanade.
/// @param static_source  where points of the static world were.
/// @param reach  lattice points to the left and right, at most kSearchReach.
/// @return the shift of the lowest mean zero-mean difference; none where no shift is much
///   better than the others around it.
std::optional<ShiftFound> searchShift(const ImagePyramid& current, const ImagePyramid& previous,
                                      const SourceOf& static_source, const cv::Mat1f& disparity_px,
                                      const std::vector<cv::Point>& points,
                                      int reach = kSearchReach);

}  // namespace predictive_stereo
