/// Messages of a stereo camera as types of the core: images as OpenCV matrices, without a copy
/// where possible, calibrations as rigs.
#pragma once

#include <predictive_stereo/RowAlignment.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>

#include <opencv2/core.hpp>
#include <string>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

std::string sizeText(cv::Size size);
cv::Size sizeOf(const sensor_msgs::Image& message);

/// @throws std::invalid_argument if the sizes of two images differ.
void requireOneCamera(const std::string& name, cv::Size size, const std::string& other,
                      cv::Size expected);

/// A writable view of a message made by allocateImage.
template <class Pixel>
cv::Mat_<Pixel> writableView(sensor_msgs::Image& message) {
  return cv::Mat_<Pixel>(static_cast<int>(message.height), static_cast<int>(message.width),
                         reinterpret_cast<Pixel*>(message.data.data()), message.step);
}

/// Sets a message's header, size and encoding (mono8, bgr8, 16UC1 or 32FC1), and allocates its
/// data, which are not initialised.
template <class Pixel>
cv::Mat_<Pixel> allocateImage(const std_msgs::Header& header, cv::Size size,
                              sensor_msgs::Image& message) {
  constexpr int kType = cv::traits::Type<Pixel>::value;
  message.header = header;
  message.width = static_cast<uint32_t>(size.width);
  message.height = static_cast<uint32_t>(size.height);
  message.encoding = kType == CV_8UC1    ? "mono8"
                     : kType == CV_8UC3  ? "bgr8"
                     : kType == CV_16UC1 ? "16UC1"
                                         : "32FC1";
  message.is_bigendian = false;
  message.step = message.width * static_cast<uint32_t>(sizeof(Pixel));
  message.data.resize(static_cast<size_t>(message.step) * message.height);
  return writableView<Pixel>(message);
}

/// The image in 8-bit grey. For mono8 the result shares the message's memory, so the message must
/// outlive it. Other encodings that cv_bridge converts to mono8 (colours, Bayer patterns, yuv422,
/// 16 bit) get separate memory. In 16-bit images 65535 becomes 255, so those that do not use the
/// upper bits become dark.
/// @param name  "left" or "right", for errors.
/// @throws std::invalid_argument for another encoding, or for fewer data than the size needs.
cv::Mat1b greyImage(const sensor_msgs::Image& message, const std::string& name);

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

/// A synchronised pair of rectified images with its calibration.
struct StereoPair {
  sensor_msgs::ImageConstPtr left, right;
  sensor_msgs::CameraInfoConstPtr left_info, right_info;
};

/// The messages of one frame for MovingObjects, all with the left image's stamp. The predicted maps
/// may be nullptr; the paper's scheme needs them.
struct MovingObjectsInput {
  sensor_msgs::ImageConstPtr left;
  sensor_msgs::CameraInfoConstPtr left_info;
  stereo_msgs::DisparityImageConstPtr measured_disparity, predicted_disparity;
  sensor_msgs::ImageConstPtr measured_variance, predicted_variance;
  RowAlignmentConstPtr row_alignment;  ///< has the column offset; nullptr: keep the last one
};

/// The rig of a pair's calibration, reduced to the region of interest and binning of the images.
/// @throws std::invalid_argument for a calibration that cannot be used (see
///   StereoRig::fromProjections) or for images of another size.
StereoRig stereoRig(const StereoPair& pair);

/// The pair as a frame. Its images may share the memory of the messages, see greyImage.
/// @throws std::invalid_argument  as stereoRig, greyImage and requireStamp.
StereoFrame stereoFrame(const StereoPair& pair, const cv::Mat1b& robot_mask = {});

/// The image file of the parameter robot_mask, see StereoFrame::robot_mask; "": an empty one.
/// @throws std::invalid_argument if the file is not an image.
cv::Mat1b readRobotMask(const std::string& file);

/// Masks of moving objects. A subscription to this topic wakes MovingObjects.
constexpr char kMaskTopic[] = "moving_objects/mask";
/// The same masks, while another subscriber keeps MovingObjects awake; a subscription to this topic
/// does not. Without it, two nodelets that need each other would never sleep.
constexpr char kPassiveMaskTopic[] = "moving_objects/passive_mask";
/// See MessageInput: the newest one is kept. One that waits longer than one other is of no use.
constexpr size_t kMasksKept = 1;
constexpr uint32_t kMaskQueue = 2;

/// View of the mask of moving objects of the previous frame, as input of the core; it shares the
/// message's memory.
/// @param left  an image of the sequence.
/// @throws std::invalid_argument for a mask with another encoding than mono8, or another size than
///   `left`.
cv::Mat1b movedMask(const sensor_msgs::Image& message, const sensor_msgs::Image& left);

/// What is wrong with an image without frame_id: tf cannot be asked for its frame.
constexpr char kNoFrame[] = "left/image_rect has an empty frame_id: set it in the camera driver";

Stamp stampOf(ros::Time time);
ros::Time rosTime(Stamp stamp);

/// Estimated offsets of rows and columns of the right image.
RowAlignment::Ptr rowAlignmentMsg(const RowOffsetModel& rows, const ColumnOffset& columns,
                                  const std_msgs::Header& header);
ColumnOffset columnOffset(const RowAlignment& message);

/// A CameraInfo's 3x4 projection matrix in pixels of its (cropped, binned) images.
Matrix34d projectionMatrix(const sensor_msgs::CameraInfo& info);

}  // namespace predictive_stereo
