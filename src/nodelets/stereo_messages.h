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

Stamp stampOf(ros::Time time);
ros::Time rosTime(Stamp stamp);

/// Estimated offsets of rows and columns of the right image.
RowAlignment::Ptr rowAlignmentMsg(const RowOffsetModel& rows, const ColumnOffset& columns,
                                  const std_msgs::Header& header);
ColumnOffset columnOffset(const RowAlignment& message);

/// A CameraInfo's 3x4 projection matrix in pixels of its (cropped, binned) images.
Matrix34d projectionMatrix(const sensor_msgs::CameraInfo& info);

}  // namespace predictive_stereo
