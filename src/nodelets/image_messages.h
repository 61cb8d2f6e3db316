/// Views of image messages as OpenCV matrices, without a copy.
#pragma once

#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>

#include <opencv2/core.hpp>
#include <string>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Sets a message's header, size and encoding and allocates its data, which are not initialised.
void allocateImage(const std_msgs::Header& header, cv::Size size, const std::string& encoding,
                   sensor_msgs::Image& message);

/// A writable view of a message made by allocateImage.
template <class Pixel>
cv::Mat_<Pixel> writableView(sensor_msgs::Image& message) {
  return cv::Mat_<Pixel>(static_cast<int>(message.height), static_cast<int>(message.width),
                         reinterpret_cast<Pixel*>(message.data.data()), message.step);
}

/// A read-only view of a 32FC1 message from any publisher.
/// @param name  of the topic, for errors.
/// @throws std::invalid_argument for another encoding, byte order or alignment, or for too few
///   data.
cv::Mat1f floatView(const sensor_msgs::Image& message, const std::string& name);

/// The range that a DisparityImage declares. Its invalid pixels are below min_disparity.
/// @throws std::invalid_argument for numbers that are not a valid range.
DisparityRange rangeOf(const stereo_msgs::DisparityImage& message);

}  // namespace predictive_stereo
