#include "nodelets/image_messages.h"

#include <sensor_msgs/image_encodings.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace predictive_stereo {

void allocateImage(const std_msgs::Header& header, cv::Size size, const std::string& encoding,
                   sensor_msgs::Image& message) {
  namespace encodings = sensor_msgs::image_encodings;
  message.header = header;
  message.width = static_cast<uint32_t>(size.width);
  message.height = static_cast<uint32_t>(size.height);
  message.encoding = encoding;
  message.is_bigendian = false;
  message.step =
      message.width * encodings::numChannels(encoding) * (encodings::bitDepth(encoding) / 8);
  message.data.resize(static_cast<size_t>(message.step) * message.height);
}

cv::Mat1f floatView(const sensor_msgs::Image& message, const std::string& name) {
  if (message.encoding != sensor_msgs::image_encodings::TYPE_32FC1 || message.is_bigendian)
    throw std::invalid_argument(name + " has encoding '" + message.encoding +
                                (message.is_bigendian ? "' (big-endian)" : "'") +
                                ": must be little-endian 32FC1");
  const size_t row_bytes = message.width * sizeof(float);
  if (message.width == 0 || message.height == 0 || message.step < row_bytes ||
      message.step % sizeof(float) != 0 ||
      message.data.size() < static_cast<size_t>(message.step) * (message.height - 1) + row_bytes ||
      reinterpret_cast<std::uintptr_t>(message.data.data()) % alignof(float) != 0)
    throw std::invalid_argument(name + " is broken: " + std::to_string(message.width) + "x" +
                                std::to_string(message.height) + " with step " +
                                std::to_string(message.step) + " and " +
                                std::to_string(message.data.size()) + " bytes of data");
  return cv::Mat1f(static_cast<int>(message.height), static_cast<int>(message.width),
                   reinterpret_cast<float*>(const_cast<uint8_t*>(message.data.data())),
                   message.step);
}

DisparityRange rangeOf(const stereo_msgs::DisparityImage& message) {
  constexpr float kLargest_px = 1e6f;
  if (!(std::abs(message.min_disparity) <= kLargest_px &&
        std::abs(message.max_disparity) <= kLargest_px))
    throw std::invalid_argument(
        "disparity message has min_disparity = " + std::to_string(message.min_disparity) +
        " and max_disparity = " + std::to_string(message.max_disparity) +
        " px: its publisher must set both limits of its disparities");
  DisparityRange range;
  range.min_disparity = static_cast<int>(std::floor(message.min_disparity));
  range.count = static_cast<int>(std::ceil(message.max_disparity)) - range.min_disparity + 1;
  return range;
}

}  // namespace predictive_stereo
