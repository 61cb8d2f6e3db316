/// Disparities and moving objects in other forms, made from messages on demand: images, depth,
/// point clouds, markers.
#pragma once

#include <predictive_stereo/MovingObjectArray.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <stereo_msgs/DisparityImage.h>
#include <visualization_msgs/MarkerArray.h>

#include <optional>

#include "nodelets/nodelet_params.h"
#include "nodelets/stereo_messages.h"
#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// bgr8 with a perceptually uniform colour map: blue far, red near; unknown pixels are black.
sensor_msgs::ImagePtr colourImage(const stereo_msgs::DisparityImage& disparity);

/// 32FC1 standard deviation [px] of a variance [px^2]; 0: unknown.
/// @throws std::invalid_argument if `variance` is not 32FC1.
sensor_msgs::ImagePtr standardDeviationImage(const sensor_msgs::Image& variance);

/// 32FC1 depth [m] (REP 118): NaN: unknown; +inf: zero disparity.
sensor_msgs::ImagePtr depthImage(const stereo_msgs::DisparityImage& disparity);

enum class MovingPoints { kTinted, kLeftOut };

/// What clouds of one frame are made from.
struct CloudSource {
  stereo_msgs::DisparityImageConstPtr disparity;
  sensor_msgs::ImageConstPtr left;  ///< gives the colours
  StereoRig rig;
  PointsParams params;
  /// mono8, of the disparity's size: not 0 on moving objects; nullptr: these are not known.
  sensor_msgs::ImageConstPtr mask;
};

/// Organised cloud (x, y, z [m], rgb) in the left camera's optical frame. Points that are unknown,
/// left out or beyond the range are NaN. With a stride n the cloud has every n-th row and column,
/// starting with the first one.
/// @throws std::invalid_argument for a mask or an image with another size or encoding.
sensor_msgs::PointCloud2Ptr pointCloud(const CloudSource& source, MovingPoints moving);

/// The first marker deletes those of the previous frame. Then each object has a 3-D box, a label
/// with id, distance and speed, and an arrow for its motion in one second (if its velocity and the
/// camera's pose are known).
visualization_msgs::MarkerArrayPtr markers(const MovingObjectArray& objects,
                                           const std::optional<CameraPose>& pose);

/// The left image (bgr8) with moving pixels tinted red, and the boxes and labels of the objects.
/// @throws std::invalid_argument for an image that is not 8-bit, or a mask with another size.
sensor_msgs::ImagePtr overlay(const sensor_msgs::Image& left, const MovingObjectArray& objects,
                              const sensor_msgs::Image& mask);

/// The residual of normalizedResidual as 32FC1; nullptr without predicted maps.
/// @throws std::invalid_argument for maps that are not 32FC1 or differ in size.
sensor_msgs::ImagePtr residualImage(const MovingObjectsInput& frame);

}  // namespace predictive_stereo
