/// Conversions of camera messages to the types of the core.
#pragma once

#include <predictive_stereo/RowAlignment.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <opencv2/core.hpp>
#include <string>

#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

/// A synchronised pair of rectified images with its calibration.
struct StereoPair {
  sensor_msgs::ImageConstPtr left, right;
  sensor_msgs::CameraInfoConstPtr left_info, right_info;
};

/// The image in 8-bit grey. For mono8 the result shares the message's memory, so the message must
/// outlive it. Other encodings that cv_bridge converts to mono8 (colours, Bayer patterns, yuv422,
/// 16 bit) are written to `buffer`. In 16-bit images 65535 becomes 255, so those that do not use
/// the upper bits become dark.
/// @param name  "left" or "right", for errors.
/// @throws std::invalid_argument for another encoding, or for fewer data than the size needs.
cv::Mat1b greyImage(const sensor_msgs::Image& message, const char* name, cv::Mat1b& buffer);

/// The image as bgr8, where the largest value of its encoding becomes 255; in separate memory.
/// @throws std::invalid_argument  as greyImage.
cv::Mat3b bgrImage(const sensor_msgs::Image& message, const char* name);

/// The rig of a pair's calibration, reduced to the region of interest and binning of the images.
/// @throws std::invalid_argument for a calibration that cannot be used (see
///   StereoRig::fromProjections) or for images of another size.
StereoRig stereoRig(const StereoPair& pair);

/// The pair as a frame. Its images share the memory of the messages or of the buffers, see
/// greyImage.
/// @throws std::invalid_argument  as stereoRig, greyImage and requireStamp.
StereoFrame stereoFrame(const StereoPair& pair, cv::Mat1b& left_buffer, cv::Mat1b& right_buffer);

/// View of the mask of moving objects of the previous frame, as input of the core; it shares the
/// message's memory.
/// @param left  an image of the sequence.
/// @throws std::invalid_argument for a mask with another encoding than mono8, or another size than
///   `left`.
cv::Mat1b movedMask(const sensor_msgs::Image& message, const sensor_msgs::Image& left);

/// What is wrong with an image without frame_id: tf cannot be asked for its frame.
constexpr char kNoFrame[] = "left/image_rect has an empty frame_id: set it in the camera driver";

/// @throws std::invalid_argument for an image without frame_id.
void requireFrame(const sensor_msgs::Image& left);

Stamp stampOf(ros::Time time);
ros::Time rosTime(Stamp stamp);

/// Estimated offsets of rows and columns of the right image.
RowAlignment::Ptr rowAlignmentMsg(const RowOffsetModel& rows, const ColumnOffset& columns,
                                  const std_msgs::Header& header);
ColumnOffset columnOffset(const RowAlignment& message);

/// A CameraInfo's 3x4 projection matrix in pixels of its (cropped, binned) images.
Matrix34d projectionMatrix(const sensor_msgs::CameraInfo& info);

}  // namespace predictive_stereo
