#include "nodelets/compressed_image.h"

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>

#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

namespace predictive_stereo {
namespace {

namespace encodings = sensor_msgs::image_encodings;

// compressed_image_transport writes a `format` that begins with the encoding before compression.
std::string encodingOf(const cv::Mat& image, const std::string& format) {
  const std::string original = format.substr(0, format.find(';'));
  switch (image.type()) {
    case CV_8UC1:
      return encodings::isBayer(original) ? original : encodings::MONO8;
    case CV_16UC1:
      return encodings::isBayer(original) ? original : encodings::MONO16;
    case CV_8UC3:
      return encodings::BGR8;
    case CV_8UC4:
      return encodings::BGRA8;
    default:
      throw std::invalid_argument("compressed image of format '" + format +
                                  "' is neither 8-bit nor grey: send it as mono8 or bgr8");
  }
}

}  // namespace

sensor_msgs::ImagePtr decodedImage(const sensor_msgs::CompressedImage& message) {
  cv::Mat image;
  try {
    if (!message.data.empty()) image = cv::imdecode(message.data, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {  // the same as for data that are not an image
  }
  if (image.empty())
    throw std::invalid_argument("compressed image of format '" + message.format + "' with " +
                                std::to_string(message.data.size()) +
                                " bytes is neither JPEG nor PNG: set image_transport to the one "
                                "that the camera driver uses");
  return cv_bridge::CvImage(message.header, encodingOf(image, message.format), image).toImageMsg();
}

}  // namespace predictive_stereo
