#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/frame_comparison.h"

namespace predictive_stereo {

/// Where a group of lattice points as a whole was in the previous frame, against where the static
/// world puts it: found by trying all shifts, for what moves too far for Lucas-Kanade.
/// @param static_source  where points of the static world were.
/// @return the shift [px] of the lowest mean zero-mean difference; none where no shift is much
///   better than the others around it.
std::optional<cv::Point> searchShift(const ImagePyramid& current, const ImagePyramid& previous,
                                     const SourceOf& static_source, const cv::Mat1f& disparity_px,
                                     const std::vector<cv::Point>& points);

}  // namespace predictive_stereo
