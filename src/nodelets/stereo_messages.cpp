#include "nodelets/stereo_messages.h"

#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace predictive_stereo {
namespace {

namespace encodings = sensor_msgs::image_encodings;

struct GreyConversion {
  const std::string& encoding;
  int channels;
  int code;
};

const GreyConversion* greyConversion(const std::string& encoding) {
  // OpenCV names Bayer patterns by their second row, ROS by their first.
  static const GreyConversion conversions[] = {
      {encodings::BGR8, 3, cv::COLOR_BGR2GRAY},
      {encodings::RGB8, 3, cv::COLOR_RGB2GRAY},
      {encodings::TYPE_8UC3, 3, cv::COLOR_BGR2GRAY},
      {encodings::BGRA8, 4, cv::COLOR_BGRA2GRAY},
      {encodings::RGBA8, 4, cv::COLOR_RGBA2GRAY},
      {encodings::TYPE_8UC4, 4, cv::COLOR_BGRA2GRAY},
      {encodings::BAYER_RGGB8, 1, cv::COLOR_BayerBG2GRAY},
      {encodings::BAYER_BGGR8, 1, cv::COLOR_BayerRG2GRAY},
      {encodings::BAYER_GBRG8, 1, cv::COLOR_BayerGR2GRAY},
      {encodings::BAYER_GRBG8, 1, cv::COLOR_BayerGB2GRAY},
  };
  for (const GreyConversion& conversion : conversions)
    if (conversion.encoding == encoding) return &conversion;
  return nullptr;
}

std::string sizeText(unsigned width, unsigned height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// Views the data of a message with `channels` bytes a pixel.
cv::Mat bytes(const sensor_msgs::Image& message, const char* name, int channels) {
  const size_t row_bytes = static_cast<size_t>(message.width) * channels;
  if (message.width == 0 || message.height == 0 || message.step < row_bytes ||
      message.data.size() < static_cast<size_t>(message.step) * (message.height - 1) + row_bytes)
    throw std::invalid_argument(
        std::string(name) + " image is broken: " + sizeText(message.width, message.height) + " " +
        message.encoding + " with step " + std::to_string(message.step) + " but only " +
        std::to_string(message.data.size()) + " bytes of data");
  return cv::Mat(static_cast<int>(message.height), static_cast<int>(message.width),
                 CV_8UC(channels), const_cast<uint8_t*>(message.data.data()), message.step);
}

// The size of the images that a CameraInfo describes; CameraInfo itself gives that of the sensor.
cv::Size imageSize(const sensor_msgs::CameraInfo& info) {
  const unsigned width = info.roi.width > 0 ? info.roi.width : info.width;
  const unsigned height = info.roi.height > 0 ? info.roi.height : info.height;
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
  if (message.encoding == encodings::MONO8 || message.encoding == encodings::TYPE_8UC1)
    return bytes(message, name, 1);
  const GreyConversion* conversion = greyConversion(message.encoding);
  if (!conversion)
    throw std::invalid_argument(std::string(name) + " image has encoding '" + message.encoding +
                                "': 8-bit images are needed (mono8, bgr8, rgb8, bgra8, rgba8 or "
                                "bayer_*8); set the camera driver to one of them");
  cv::cvtColor(bytes(message, name, conversion->channels), buffer, conversion->code);
  return buffer;
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
  StereoFrame frame;
  frame.rig = stereoRig(pair);
  frame.left = greyImage(*pair.left, "left", left_buffer);
  frame.right = greyImage(*pair.right, "right", right_buffer);
  frame.stamp = stampOf(pair.left->header.stamp);
  return frame;
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
