#include "nodelets/stereo_messages.h"

#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <limits>
#include <stdexcept>
#include <string>

#include "nodelets/image_messages.h"
#include "nodelets/message_checks.h"

namespace predictive_stereo {
namespace {

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
  requireOneCamera("moving_objects/mask", sizeOf(message), "left image", sizeOf(left));
  cv::Mat1b unused;
  return greyImage(message, "moving_objects/mask", unused);
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
