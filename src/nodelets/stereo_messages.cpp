#include "nodelets/stereo_messages.h"

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <limits>
#include <stdexcept>
#include <utility>

#include "nodelets/message_checks.h"

namespace predictive_stereo {
namespace {

namespace encodings = sensor_msgs::image_encodings;

std::string sizeText(unsigned width, unsigned height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// Colour encoding of one that gives only the number of channels: OpenCV's order of channels.
std::string colourEncoding(const std::string& encoding) {
  if (encoding == encodings::TYPE_8UC1) return encodings::MONO8;
  if (encoding == encodings::TYPE_8UC3) return encodings::BGR8;
  if (encoding == encodings::TYPE_8UC4) return encodings::BGRA8;
  if (encoding == encodings::TYPE_16UC1) return encodings::MONO16;
  return encoding;
}

void requireData(const sensor_msgs::Image& message, const char* name, size_t pixel_bytes) {
  const size_t row_bytes = message.width * pixel_bytes;
  if (message.width == 0 || message.height == 0 || message.step < row_bytes ||
      message.data.size() < static_cast<size_t>(message.step) * (message.height - 1) + row_bytes)
    throw std::invalid_argument(
        std::string(name) + " image is broken: " + sizeText(message.width, message.height) + " " +
        message.encoding + " with step " + std::to_string(message.step) + " but only " +
        std::to_string(message.data.size()) + " bytes of data");
}

// The image in little-endian byte order. (cv_bridge 1.16 does not convert big-endian images
// correctly.)
sensor_msgs::Image littleEndian(const sensor_msgs::Image& message) {
  sensor_msgs::Image result = message;
  for (size_t i = 0; i + 1 < result.data.size(); i += 2)
    std::swap(result.data[i], result.data[i + 1]);
  result.is_bigendian = false;
  return result;
}

// Conversion by cv_bridge, into separate memory.
cv::Mat converted(const sensor_msgs::Image& message, const char* name, const std::string& target) {
  try {
    const std::string& encoding = message.encoding;
    requireData(
        message, name,
        static_cast<size_t>(encodings::numChannels(encoding)) * encodings::bitDepth(encoding) / 8);
    if (message.is_bigendian && encodings::bitDepth(encoding) == 16)
      return converted(littleEndian(message), name, target);
    const cv_bridge::CvImageConstPtr source =
        cv_bridge::toCvShare(message, boost::shared_ptr<void>());
    const auto coloured = boost::make_shared<cv_bridge::CvImage>(
        message.header, colourEncoding(encoding), source->image);
    return cv_bridge::cvtColor(coloured, target)->image;
  } catch (const std::runtime_error& error) {  // of cv_bridge, OpenCV or sensor_msgs' encodings
    throw std::invalid_argument(std::string(name) + " image has encoding '" + message.encoding +
                                "', which cannot be converted to " + target + " (" + error.what() +
                                "); set the camera driver to mono8 or bgr8");
  } catch (const cv::Exception& error) {
    throw std::invalid_argument(std::string(name) + " image of encoding '" + message.encoding +
                                "' cannot be converted to " + target + ": " + error.what());
  }
}

// Size of the images that a CameraInfo describes; its width and height are those of the sensor.
cv::Size imageSize(const sensor_msgs::CameraInfo& info) {
  const unsigned width = info.roi.width > 0 ? info.roi.width : info.width;
  const unsigned height = info.roi.height > 0 ? info.roi.height : info.height;
  constexpr unsigned kLargest = std::numeric_limits<int>::max();
  if (width > kLargest || height > kLargest)
    throw std::invalid_argument("camera_info is for " + sizeText(width, height) +
                                " images: no camera has this size; calibrate it again");
  return cv::Size(static_cast<int>(width / std::max(1u, info.binning_x)),
                  static_cast<int>(height / std::max(1u, info.binning_y)));
}

void requireSize(const char* name, const sensor_msgs::Image& image, cv::Size calibrated) {
  if (static_cast<int>(image.width) == calibrated.width &&
      static_cast<int>(image.height) == calibrated.height)
    return;
  throw std::invalid_argument(
      std::string(name) + " image is " + sizeText(image.width, image.height) +
      " but its camera_info is for " + sizeText(calibrated.width, calibrated.height) +
      " images; do both topics belong to one camera, and was it calibrated at this resolution?");
}

}  // namespace

cv::Mat1b greyImage(const sensor_msgs::Image& message, const char* name, cv::Mat1b& buffer) {
  if (message.encoding == encodings::MONO8 || message.encoding == encodings::TYPE_8UC1) {
    requireData(message, name, 1);
    return cv::Mat1b(static_cast<int>(message.height), static_cast<int>(message.width),
                     const_cast<uint8_t*>(message.data.data()), message.step);
  }
  buffer = converted(message, name, encodings::MONO8);
  return buffer;
}

cv::Mat3b bgrImage(const sensor_msgs::Image& message, const char* name) {
  return converted(message, name, encodings::BGR8);
}

Matrix34d projectionMatrix(const sensor_msgs::CameraInfo& info) {
  Matrix34d P = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(info.P.data());
  P(0, 2) -= info.roi.x_offset;
  P(1, 2) -= info.roi.y_offset;
  P.row(0) /= std::max(1u, info.binning_x);
  P.row(1) /= std::max(1u, info.binning_y);
  return P;
}

StereoRig stereoRig(const StereoPair& pair) {
  if (pair.left->width != pair.right->width || pair.left->height != pair.right->height)
    throw std::invalid_argument("left image is " + sizeText(pair.left->width, pair.left->height) +
                                " but the right one is " +
                                sizeText(pair.right->width, pair.right->height) +
                                "; rectify both to one size");
  const StereoRig rig =
      StereoRig::fromProjections(projectionMatrix(*pair.left_info),
                                 projectionMatrix(*pair.right_info), imageSize(*pair.left_info));
  requireSize("left", *pair.left, imageSize(*pair.left_info));
  requireSize("right", *pair.right, imageSize(*pair.right_info));
  return rig;
}

StereoFrame stereoFrame(const StereoPair& pair, cv::Mat1b& left_buffer, cv::Mat1b& right_buffer) {
  requireStamp(pair.left->header.stamp, ZeroStamp::kLegal);
  StereoFrame frame;
  frame.rig = stereoRig(pair);
  frame.left = greyImage(*pair.left, "left", left_buffer);
  frame.right = greyImage(*pair.right, "right", right_buffer);
  frame.stamp = stampOf(pair.left->header.stamp);
  return frame;
}

cv::Mat1b movedMask(const sensor_msgs::Image& message, const sensor_msgs::Image& left) {
  if (message.width != left.width || message.height != left.height)
    throw std::invalid_argument("mask of moving objects is " + std::to_string(message.width) + "x" +
                                std::to_string(message.height) + " but the image is " +
                                std::to_string(left.width) + "x" + std::to_string(left.height) +
                                "; do the topics belong to one camera?");
  cv::Mat1b unused;
  return greyImage(message, "moving_objects/mask", unused);
}

void requireFrame(const sensor_msgs::Image& left) {
  if (left.header.frame_id.empty()) throw std::invalid_argument(kNoFrame);
}

Stamp stampOf(ros::Time time) {
  return std::chrono::seconds(time.sec) + std::chrono::nanoseconds(time.nsec);
}

ros::Time rosTime(Stamp stamp) {
  ros::Time time;
  time.fromNSec(static_cast<uint64_t>(stamp.count()));
  return time;
}

RowAlignment::Ptr rowAlignmentMsg(const RowOffsetModel& rows, const ColumnOffset& columns,
                                  const std_msgs::Header& header) {
  const auto message = boost::make_shared<RowAlignment>();
  message->header = header;
  for (int i = 0; i < 6; ++i) message->coefficients[i] = rows.coefficients_px(i);
  message->samples = static_cast<uint32_t>(rows.samples);
  message->residual = rows.residual_px;
  message->largest_offset = rows.largest_offset_px;
  if (columns.known) {
    message->column_offset = columns.offset_px;
    message->column_offset_sigma = columns.sigma_px;
  }
  message->column_correction = columns.correction_px;
  return message;
}

ColumnOffset columnOffset(const RowAlignment& message) {
  ColumnOffset columns;
  columns.known = message.column_offset_sigma > 0;
  columns.offset_px = message.column_offset;
  columns.sigma_px = message.column_offset_sigma;
  columns.correction_px = message.column_correction;
  return columns;
}

}  // namespace predictive_stereo
