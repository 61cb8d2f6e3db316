/// Image messages as OpenCV matrices, without a copy where possible.
#pragma once

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>

#include <opencv2/core.hpp>
#include <string>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

std::string sizeText(cv::Size size);
cv::Size sizeOf(const sensor_msgs::Image& message);

/// @throws std::invalid_argument if the sizes of two images differ.
void requireOneCamera(const std::string& name, cv::Size size, const std::string& other,
                      cv::Size expected);

/// Sets a message's header, size and encoding and allocates its data, which are not initialised.
void allocateImage(const std_msgs::Header& header, cv::Size size, const std::string& encoding,
                   sensor_msgs::Image& message);

/// The same for a new message.
sensor_msgs::ImagePtr newImage(const std_msgs::Header& header, cv::Size size,
                               const std::string& encoding);

/// A writable view of a message made by allocateImage or newImage.
template <class Pixel>
cv::Mat_<Pixel> writableView(sensor_msgs::Image& message) {
  return cv::Mat_<Pixel>(static_cast<int>(message.height), static_cast<int>(message.width),
                         reinterpret_cast<Pixel*>(message.data.data()), message.step);
}

/// The image in 8-bit grey. For mono8 the result shares the message's memory, so the message must
/// outlive it. Other encodings that cv_bridge converts to mono8 (colours, Bayer patterns, yuv422,
/// 16 bit) are written to `buffer`. In 16-bit images 65535 becomes 255, so those that do not use
/// the upper bits become dark.
/// @param name  "left" or "right", for errors.
/// @throws std::invalid_argument for another encoding, or for fewer data than the size needs.
cv::Mat1b greyImage(const sensor_msgs::Image& message, const std::string& name, cv::Mat1b& buffer);

/// The image as bgr8, where the largest value of its encoding becomes 255; in separate memory.
/// @throws std::invalid_argument  as greyImage.
cv::Mat3b bgrImage(const sensor_msgs::Image& message, const std::string& name);

/// Suffix of an image topic when image_transport sends it as JPEG or PNG.
constexpr char kCompressedTopic[] = "/compressed";

/// Decodes a JPEG or PNG message: mono8, mono16, bgr8, bgra8, or the Bayer pattern that `format`
/// names.
/// @throws std::invalid_argument for data that are not such an image.
sensor_msgs::ImagePtr decodedImage(const sensor_msgs::CompressedImage& message);

/// A read-only view of a 32FC1 message from any publisher.
/// @param name  of the topic, for errors.
/// @throws std::invalid_argument for another encoding, byte order or alignment, or for too few
///   data.
cv::Mat1f floatView(const sensor_msgs::Image& message, const std::string& name);

/// The range that a DisparityImage declares. Its invalid pixels are below min_disparity.
/// @throws std::invalid_argument for numbers that are not a valid range.
DisparityRange rangeOf(const stereo_msgs::DisparityImage& message);

}  // namespace predictive_stereo
