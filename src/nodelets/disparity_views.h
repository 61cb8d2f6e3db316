/// Other representations of disparities: images, depth, point clouds. Made from messages, on
/// demand.
#pragma once

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <stereo_msgs/DisparityImage.h>

#include "nodelets/nodelet_params.h"
#include "nodelets/stereo_messages.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// The image inside a DisparityImage as a separate message; it shares the memory.
sensor_msgs::ImageConstPtr innerImage(const stereo_msgs::DisparityImageConstPtr& disparity);

/// bgr8 with a perceptually uniform colour map: blue far, red near; unknown pixels are black.
sensor_msgs::ImagePtr colourImage(const stereo_msgs::DisparityImage& disparity);

/// 32FC1 standard deviation [px] of a variance [px^2]; 0: unknown.
/// @throws std::invalid_argument if `variance` is not 32FC1.
sensor_msgs::ImagePtr standardDeviationImage(const sensor_msgs::Image& variance);

/// 32FC1 depth [m] (REP 118): NaN: unknown; +inf: zero disparity.
sensor_msgs::ImagePtr depthImage(const stereo_msgs::DisparityImage& disparity);

/// The left camera's calibration with the stamp of the left image.
sensor_msgs::CameraInfoPtr depthCameraInfo(const StereoPair& pair);

enum class MovingPoints { kTinted, kLeftOut };

/// Organised cloud (x, y, z [m], rgb) in the left camera's optical frame. Points that are unknown,
/// left out or beyond the range are NaN. With a stride n the cloud has every n-th row and column,
/// starting with the first one.
/// @param left  gives the colours.
/// @param moving_mask  mono8, of the disparity's size: not 0 on moving objects; may be null.
/// @throws std::invalid_argument for a mask or an image with another size or encoding.
sensor_msgs::PointCloud2Ptr pointCloud(const stereo_msgs::DisparityImage& disparity,
                                       const StereoRig& rig, const sensor_msgs::Image& left,
                                       const sensor_msgs::Image* moving_mask,
                                       const PointsParams& params = {},
                                       MovingPoints moving = MovingPoints::kTinted);

}  // namespace predictive_stereo
