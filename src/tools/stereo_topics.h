#pragma once

#include <rosbag/bag.h>
#include <rosbag/message_instance.h>
#include <sensor_msgs/Image.h>

#include <string>

namespace predictive_stereo {

/// The topics of a stereo camera in a bag. Images may be compressed: their topics then end in
/// /compressed.
struct StereoTopics {
  std::string left, left_info, right, right_info;
};

/// How a user may name them.
struct StereoTopicChoice {
  std::string camera;       ///< namespace: <camera>/left/image_rect, ...; or empty
  std::string left, right;  ///< image topics; their camera_info lie beside them; or empty
  bool raw = false;         ///< images that are not rectified yet: image_raw, not image_rect
};

/// The topic whose images are sent on `topic`: without the /compressed at its end.
std::string imageTopic(const std::string& topic);

/// The image of a sensor_msgs/Image message or, unpacked, of a sensor_msgs/CompressedImage; null:
/// the message is neither.
/// @throws std::invalid_argument where it cannot be unpacked.
sensor_msgs::ImageConstPtr imageOf(const rosbag::MessageInstance& message);

/// Finds the topics that were chosen, or, where nothing was, those of the only camera whose layout
/// is known (<camera>/left/image_rect, or KITTI's camera_{gray,color}_{left,right}; where `raw`,
/// <camera>/left/image_raw).
/// @throws std::runtime_error that lists the bag's image topics where one is not there, or where
///   the choice is open.
StereoTopics findStereoTopics(const rosbag::Bag& bag, const StereoTopicChoice& choice);

}  // namespace predictive_stereo
