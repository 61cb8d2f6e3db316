/// Moving objects as pictures and as rviz markers, on demand.
#pragma once

#include <predictive_stereo/MovingObjectArray.h>
#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>
#include <visualization_msgs/MarkerArray.h>

#include <Eigen/Geometry>
#include <optional>

namespace predictive_stereo {

/// The first marker deletes those of the frame before; then, per object, its 3-D box, a label with
/// its id, distance and speed, and the way that it goes in one second as an arrow (where both its
/// velocity and the camera's pose are known).
visualization_msgs::MarkerArrayPtr markers(const MovingObjectArray& objects,
                                           const std::optional<Eigen::Isometry3d>& T_odom_cam);

/// The left image (bgr8), moving pixels tinted red, with the objects' boxes and labels.
/// @throws std::invalid_argument for an image that is not 8-bit, or a mask of another size.
sensor_msgs::ImagePtr overlay(const sensor_msgs::Image& left, const MovingObjectArray& objects,
                              const sensor_msgs::Image& mask);

/// The residual of normalizedResidual as 32FC1.
/// @throws std::invalid_argument for maps that are not 32FC1 or differ in size.
sensor_msgs::ImagePtr residualImage(const stereo_msgs::DisparityImage& measured,
                                    const sensor_msgs::Image& measured_variance,
                                    const stereo_msgs::DisparityImage& predicted,
                                    const sensor_msgs::Image& predicted_variance);

}  // namespace predictive_stereo
