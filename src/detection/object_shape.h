#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// Where in space the visible surface of an object is.
struct ObjectShape {
  Eigen::Vector3d centre_m;  ///< of its box, in the left camera's optical frame
  Eigen::Vector3d size_m;    ///< of its box along the axes of that frame
  double distance_m = 0;     ///< depth of its nearest part
};

/// The box around the points of the pixels with mask 255 that have a positive disparity, without
/// the outermost twentieths along each axis. None where there are fewer than eight of them.
/// @param area  part of the image that `mask` covers; of the mask's size.
std::optional<ObjectShape> shapeOf(const StereoRig& rig, const DisparityRange& range,
                                   const cv::Mat1f& disparity_px, const cv::Rect& area,
                                   const cv::Mat1b& mask);

}  // namespace predictive_stereo
