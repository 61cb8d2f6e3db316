#pragma once

#include <rosbag/bag.h>

#include <string>

namespace predictive_stereo {

/// The topics of a stereo camera in a bag.
struct StereoTopics {
  std::string left, left_info, right, right_info;
};

/// How a user may name them.
struct StereoTopicChoice {
  std::string camera;       ///< namespace: <camera>/left/image_rect, ...; or empty
  std::string left, right;  ///< image topics; their camera_info lie beside them; or empty
  bool raw = false;         ///< images that are not rectified yet: image_raw, not image_rect
};

/// Finds the topics that were chosen, or, where nothing was, those of the only camera whose layout
/// is known (<camera>/left/image_rect, or KITTI's camera_{gray,color}_{left,right}; where `raw`,
/// <camera>/left/image_raw).
/// @throws std::runtime_error that lists the bag's image topics where one is not there, or where
///   the choice is open.
StereoTopics findStereoTopics(const rosbag::Bag& bag, const StereoTopicChoice& choice);

}  // namespace predictive_stereo
