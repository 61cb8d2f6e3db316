#pragma once

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

namespace predictive_stereo {

/// Suffix of an image topic when image_transport sends it as JPEG or PNG.
constexpr char kCompressedTopic[] = "/compressed";

/// Decodes a JPEG or PNG message: mono8, mono16, bgr8, bgra8, or the Bayer pattern that `format`
/// names.
/// @throws std::invalid_argument for data that are not such an image.
sensor_msgs::ImagePtr decodedImage(const sensor_msgs::CompressedImage& message);

}  // namespace predictive_stereo
