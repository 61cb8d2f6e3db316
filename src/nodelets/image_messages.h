/// Views of image messages as OpenCV matrices, without a copy.
#pragma once

#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>

#include <opencv2/core.hpp>
#include <string>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Gives a message size, encoding and memory for an image; its data keep their old contents.
void allocateImage(const std_msgs::Header& header, cv::Size size, const std::string& encoding,
                   sensor_msgs::Image& message);

/// A writable view of a message made by allocateImage.
template <class Pixel>
cv::Mat_<Pixel> writableView(sensor_msgs::Image& message) {
  return cv::Mat_<Pixel>(static_cast<int>(message.height), static_cast<int>(message.width),
                         reinterpret_cast<Pixel*>(message.data.data()), message.step);
}

/// A view of a 32FC1 message from anywhere. Not to be written.
/// @param name  of the topic, for errors.
/// @throws std::invalid_argument for another encoding, byte order, alignment or too few data.
cv::Mat1f floatView(const sensor_msgs::Image& message, const std::string& name);

/// The range that a DisparityImage declares; its invalid pixels lie below min_disparity.
/// @throws std::invalid_argument for numbers that no range has.
DisparityRange rangeOf(const stereo_msgs::DisparityImage& message);

}  // namespace predictive_stereo
