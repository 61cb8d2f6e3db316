/// Checks whether the nodelets can use a bag.
#pragma once

#include <rosbag/bag.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tools/stereo_bag.h"

namespace predictive_stereo {

constexpr double kLookedAt_s = 30;  ///< of a bag, from its beginning

struct BagFinding {
  enum class Level {
    kGood,    ///< no problem
    kAdvice,  ///< works with the given launch arguments, or not as well as it could
    kFault,   ///< the bag cannot be used
  };
  Level level;
  std::string text;  ///< with the cure, if it is advice or a fault
};

struct BagCheck {
  std::vector<BagFinding> findings;
  std::string launch_file;             ///< of this package; empty: no camera found
  std::vector<std::string> arguments;  ///< of the launch file, without the bag

  bool isUsable() const;
  void good(const std::string& text) { findings.push_back({BagFinding::Level::kGood, text}); }
  void advice(const std::string& text) { findings.push_back({BagFinding::Level::kAdvice, text}); }
  void fault(const std::string& text) { findings.push_back({BagFinding::Level::kFault, text}); }
};

/// Checks topics, images, calibrations, stamps and tf of the bag's first half minute.
/// @param choice  the camera to check; empty: the first one with a known layout.
BagCheck checkBag(const rosbag::Bag& bag, const StereoTopicChoice& choice = {});

// Parts of checkBag.

/// A stereo camera in a bag, and the launch file and arguments that read it.
struct CameraLayout {
  std::string name;  ///< description of the camera
  StereoTopics topics;
  std::string launch_file;
  std::vector<std::string> arguments;
  /// Whether the launch file handles base_link and /tf: it has the extrinsics of this layout, and
  /// remaps the bag's /tf.
  bool knows_tf = false;
  bool is_raw = false;  ///< its images have to be rectified first
};

/// All cameras with a known layout in order of preference: rectified before raw, grey before
/// colour.
std::vector<CameraLayout> findCameras(const TopicTypes& types);

/// The camera that a user chose; its topics may be missing.
CameraLayout chosenCamera(const StereoTopicChoice& choice, const TopicTypes& types);

/// The stamps of one topic.
struct StampStream {
  std::string topic;
  std::vector<ros::Time> stamps;

  bool unstamped() const { return std::count(stamps.begin(), stamps.end(), ros::Time()) > 0; }
};

/// The part of checkBag for rate, gaps and synchronisation: adds a launch argument if stamps
/// differ.
/// @param streams  left, right, left_info, right_info; each has stamps.
void checkStamps(const std::vector<StampStream>& streams, BagCheck& result);

}  // namespace predictive_stereo
