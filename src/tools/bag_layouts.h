#pragma once

#include <rosbag/bag.h>

#include <map>
#include <string>
#include <vector>

#include "tools/stereo_topics.h"

namespace predictive_stereo {

/// A stereo camera in a bag, and the launch file and arguments that read it.
struct CameraLayout {
  std::string name;  ///< in words
  StereoTopics topics;
  std::string launch_file;
  std::vector<std::string> arguments;
  /// Whether base_link and /tf are the launch file's business: it knows where the extrinsics of
  /// this layout are, and moves the bag's /tf out of the way.
  bool knows_tf = false;
};

/// Types of a bag's topics by name.
std::map<std::string, std::string> topicTypes(const rosbag::Bag& bag);

/// All cameras whose layout is known, the best to use first: rectified before raw ones, grey before
/// colour.
std::vector<CameraLayout> findCameras(const std::map<std::string, std::string>& types);

/// The camera that a user named; its topics may be missing.
CameraLayout chosenCamera(const StereoTopicChoice& choice,
                          const std::map<std::string, std::string>& types);

}  // namespace predictive_stereo
