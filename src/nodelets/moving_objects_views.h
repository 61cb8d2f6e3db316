/// Moving objects as images and as rviz markers, on demand.
#pragma once

#include <predictive_stereo/MovingObjectArray.h>
#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>
#include <visualization_msgs/MarkerArray.h>

#include <optional>

#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {

/// The first marker deletes those of the previous frame. Then each object has a 3-D box, a label
/// with id, distance and speed, and an arrow for its motion in one second (if its velocity and the
/// camera's pose are known).
visualization_msgs::MarkerArrayPtr markers(const MovingObjectArray& objects,
                                           const std::optional<CameraPose>& pose);

/// The left image (bgr8) with moving pixels tinted red, and the boxes and labels of the objects.
/// @throws std::invalid_argument for an image that is not 8-bit, or a mask with another size.
sensor_msgs::ImagePtr overlay(const sensor_msgs::Image& left, const MovingObjectArray& objects,
                              const sensor_msgs::Image& mask);

/// The residual of normalizedResidual as 32FC1.
/// @throws std::invalid_argument for maps that are not 32FC1 or differ in size.
sensor_msgs::ImagePtr residualImage(const stereo_msgs::DisparityImage& measured,
                                    const sensor_msgs::Image& measured_variance,
                                    const stereo_msgs::DisparityImage& predicted,
                                    const sensor_msgs::Image& predicted_variance);

}  // namespace predictive_stereo
