#pragma once

#include <string>
#include <vector>

#include "tools/stereo_bag.h"

namespace predictive_stereo {

/// A stereo camera in a bag, and the launch file and arguments that read it.
struct CameraLayout {
  std::string name;  ///< description of the camera
  StereoTopics topics;
  std::string launch_file;
  std::vector<std::string> arguments;
  /// Whether the launch file handles base_link and /tf: it has the extrinsics of this layout, and
  /// remaps the bag's /tf.
  bool knows_tf = false;
};

/// All cameras with a known layout in order of preference: rectified before raw, grey before
/// colour.
std::vector<CameraLayout> findCameras(const TopicTypes& types);

/// The camera that a user chose; its topics may be missing.
CameraLayout chosenCamera(const StereoTopicChoice& choice, const TopicTypes& types);

}  // namespace predictive_stereo
