#include "nodelets/stereo_messages.h"

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <utility>

#include "nodelets/message_checks.h"

namespace predictive_stereo {
namespace {

namespace encodings = sensor_msgs::image_encodings;

// @param channel_bytes  of which each row has a whole number.
void requireData(const sensor_msgs::Image& message, const std::string& name, size_t pixel_bytes,
                 size_t channel_bytes = 1) {
  const size_t row_bytes = message.width * pixel_bytes;
  if (message.width == 0 || message.height == 0 || message.step < row_bytes ||
      message.step % channel_bytes != 0 ||
      message.data.size() < static_cast<size_t>(message.step) * (message.height - 1) + row_bytes)
    throw std::invalid_argument(name + " is broken: " + std::to_string(message.width) + "x" +
                                std::to_string(message.height) + " " + message.encoding +
                                " with step " + std::to_string(message.step) + " and " +
                                std::to_string(message.data.size()) + " bytes of data");
}

// Colour encoding of one that gives only the number of channels: OpenCV's order of channels.
std::string colourEncoding(const std::string& encoding) {
  if (encoding == encodings::TYPE_8UC1) return encodings::MONO8;
  if (encoding == encodings::TYPE_8UC3) return encodings::BGR8;
  if (encoding == encodings::TYPE_8UC4) return encodings::BGRA8;
  if (encoding == encodings::TYPE_16UC1) return encodings::MONO16;
  return encoding;
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
cv::Mat converted(const sensor_msgs::Image& message, const std::string& name,
                  const std::string& target) {
  try {
    const std::string& encoding = message.encoding;
    requireData(
        message, name + " image",
        static_cast<size_t>(encodings::numChannels(encoding)) * encodings::bitDepth(encoding) / 8);
    if (message.is_bigendian && encodings::bitDepth(encoding) == 16)
      return converted(littleEndian(message), name, target);
    const cv_bridge::CvImageConstPtr source =
        cv_bridge::toCvShare(message, boost::shared_ptr<void>());
    const auto coloured = boost::make_shared<cv_bridge::CvImage>(
        message.header, colourEncoding(encoding), source->image);
    return cv_bridge::cvtColor(coloured, target)->image;
  } catch (const std::runtime_error& error) {  // of cv_bridge, OpenCV or sensor_msgs' encodings
    throw std::invalid_argument(name + " image has encoding '" + message.encoding +
                                "', which cannot be converted to " + target + " (" + error.what() +
                                "); set the camera driver to mono8 or bgr8");
  } catch (const cv::Exception& error) {
    throw std::invalid_argument(name + " image of encoding '" + message.encoding +
                                "' cannot be converted to " + target + ": " + error.what());
  }
}

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

// Size of the images that a CameraInfo describes; its width and height are those of the sensor.
cv::Size imageSize(const sensor_msgs::CameraInfo& info) {
  const unsigned width = info.roi.width > 0 ? info.roi.width : info.width;
  const unsigned height = info.roi.height > 0 ? info.roi.height : info.height;
  constexpr unsigned kLargest = std::numeric_limits<int>::max();
  if (width > kLargest || height > kLargest)
    throw std::invalid_argument("camera_info is for " + std::to_string(width) + "x" +
                                std::to_string(height) +
                                " images: no camera has this size; calibrate it again");
  return cv::Size(static_cast<int>(width / std::max(1u, info.binning_x)),
                  static_cast<int>(height / std::max(1u, info.binning_y)));
}

void requireSize(const std::string& name, const sensor_msgs::Image& image, cv::Size calibrated) {
  if (sizeOf(image) != calibrated)
    throw std::invalid_argument(
        name + " image is " + sizeText(sizeOf(image)) + " but its camera_info is for " +
        sizeText(calibrated) +
        " images; do both topics belong to one camera, and was it calibrated at this resolution?");
}

}  // namespace

// As in the message, whose sizes are unsigned: beyond 2^31 they are negative in cv::Size.
std::string sizeText(cv::Size size) {
  return std::to_string(static_cast<unsigned>(size.width)) + "x" +
         std::to_string(static_cast<unsigned>(size.height));
}

cv::Size sizeOf(const sensor_msgs::Image& message) {
  return {static_cast<int>(message.width), static_cast<int>(message.height)};
}

void requireOneCamera(const std::string& name, cv::Size size, const std::string& other,
                      cv::Size expected) {
  if (size != expected)
    throw std::invalid_argument(name + " is " + sizeText(size) + " but " + other + " is " +
                                sizeText(expected) + "; do the topics belong to one camera?");
}

cv::Mat1b greyImage(const sensor_msgs::Image& message, const std::string& name) {
  if (message.encoding == encodings::MONO8 || message.encoding == encodings::TYPE_8UC1) {
    requireData(message, name + " image", 1);
    return cv::Mat1b(static_cast<int>(message.height), static_cast<int>(message.width),
                     const_cast<uint8_t*>(message.data.data()), message.step);
  }
  return converted(message, name, encodings::MONO8);
}

cv::Mat3b bgrImage(const sensor_msgs::Image& message, const std::string& name) {
  return converted(message, name, encodings::BGR8);
}

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

cv::Mat1f floatView(const sensor_msgs::Image& message, const std::string& name) {
  if (message.encoding != encodings::TYPE_32FC1 || message.is_bigendian)
    throw std::invalid_argument(name + " has encoding '" + message.encoding +
                                (message.is_bigendian ? "' (big-endian)" : "'") +
                                ": must be little-endian 32FC1");
  requireData(message, name, sizeof(float), sizeof(float));
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

Matrix34d projectionMatrix(const sensor_msgs::CameraInfo& info) {
  Matrix34d P = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(info.P.data());
  P(0, 2) -= info.roi.x_offset;
  P(1, 2) -= info.roi.y_offset;
  P.row(0) /= std::max(1u, info.binning_x);
  P.row(1) /= std::max(1u, info.binning_y);
  return P;
}

StereoRig stereoRig(const StereoPair& pair) {
  const cv::Size left = sizeOf(*pair.left), right = sizeOf(*pair.right);
  if (left != right)
    throw std::invalid_argument("left image is " + sizeText(left) + " but the right one is " +
                                sizeText(right) + "; rectify both to one size");
  const StereoRig rig =
      StereoRig::fromProjections(projectionMatrix(*pair.left_info),
                                 projectionMatrix(*pair.right_info), imageSize(*pair.left_info));
  requireSize("left", *pair.left, imageSize(*pair.left_info));
  requireSize("right", *pair.right, imageSize(*pair.right_info));
  return rig;
}

StereoFrame stereoFrame(const StereoPair& pair, const cv::Mat1b& robot_mask) {
  requireStamp(pair.left->header.stamp, ZeroStamp::kLegal);
  StereoFrame frame;
  frame.rig = stereoRig(pair);
  frame.left = greyImage(*pair.left, "left");
  frame.right = greyImage(*pair.right, "right");
  frame.robot_mask = robot_mask;
  frame.stamp = stampOf(pair.left->header.stamp);
  return frame;
}

cv::Mat1b readRobotMask(const std::string& file) {
  if (file.empty()) return {};
  const cv::Mat1b mask = cv::imread(file, cv::IMREAD_GRAYSCALE);
  if (mask.empty())
    throw std::invalid_argument("robot_mask = '" + file +
                                "' cannot be read as an image: give the full path of a PNG that is "
                                "white where the left camera sees the robot, and black elsewhere");
  return mask;
}

cv::Mat1b movedMask(const sensor_msgs::Image& message, const sensor_msgs::Image& left) {
  requireOneCamera("moving_objects/mask", sizeOf(message), "left image", sizeOf(left));
  return greyImage(message, "moving_objects/mask");
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
