#pragma once

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

namespace predictive_stereo {

/// What follows an image's topic where image_transport sends it as JPEG or PNG.
constexpr char kCompressedTopic[] = "/compressed";

/// The image of a JPEG or PNG message: mono8, mono16, bgr8, bgra8, or a Bayer pattern where the
/// format names one.
/// @throws std::invalid_argument for data that are no such image.
sensor_msgs::ImagePtr unpacked(const sensor_msgs::CompressedImage& message);

}  // namespace predictive_stereo
