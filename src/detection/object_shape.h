#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "detection/tracker.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// Position and size of the visible surface of an object.
struct ObjectShape {
  Eigen::Vector3d centre_m;  ///< of its box, in the left camera's optical frame
  Eigen::Vector3d size_m;    ///< of its box along the axes of that frame
  double distance_m = 0;     ///< depth of its nearest part
};

/// The 3-D box around the pixels with mask 255 and a positive disparity, without the outermost 5 %
/// at both ends of each axis. None if there are fewer than eight such pixels.
/// @param area  part of the image that `mask` covers; of the mask's size.
std::optional<ObjectShape> shapeOf(const StereoRig& rig, const DisparityRange& range,
                                   const cv::Mat1f& disparity_px, const cv::Rect& area,
                                   const cv::Mat1b& mask);

/// Sets centre, size and distance of an object whose box and mask are known. False if there are too
/// few pixels.
bool measureShape(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px,
                  ObservedObject& object);

/// Covariance [m^2] of the centre of an object with this disparity, in the camera's frame.
Eigen::Matrix3d centreCovariance(const StereoRig& rig, double disparity_px);

}  // namespace predictive_stereo
