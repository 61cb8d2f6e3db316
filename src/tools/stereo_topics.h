#pragma once

#include <rosbag/bag.h>
#include <rosbag/message_instance.h>
#include <sensor_msgs/Image.h>

#include <string>

namespace predictive_stereo {

/// The topics of a stereo camera in a bag. Topics of compressed images end in /compressed.
struct StereoTopics {
  std::string left, left_info, right, right_info;
};

/// The user's choice of a camera.
struct StereoTopicChoice {
  std::string camera;       ///< namespace: <camera>/left/image_rect, ...; or empty
  std::string left, right;  ///< image topics, with camera_info in the same namespaces; or empty
  bool raw = false;         ///< images are not rectified: image_raw, not image_rect
};

/// `topic` without the suffix /compressed.
std::string imageTopic(const std::string& topic);

/// The image of a sensor_msgs/Image, or the decoded image of a sensor_msgs/CompressedImage; nullptr
/// for other messages.
/// @throws std::invalid_argument if it cannot be decoded.
sensor_msgs::ImageConstPtr imageOf(const rosbag::MessageInstance& message);

/// Finds the chosen topics. Without a choice, those of the only camera with a known layout:
/// <camera>/left/image_rect (image_raw if `choice.raw`), or KITTI's
/// camera_{gray,color}_{left,right}.
/// @throws std::runtime_error if a topic is missing, or without a choice if there is not exactly
///   one such camera; it lists the bag's image topics.
StereoTopics findStereoTopics(const rosbag::Bag& bag, const StereoTopicChoice& choice);

/// The time `seconds` after `begin`, or the last one that ros::Time has: recorded times may be
/// anything, and ros::Time throws beyond.
ros::Time timeAfter(ros::Time begin, double seconds);

}  // namespace predictive_stereo
