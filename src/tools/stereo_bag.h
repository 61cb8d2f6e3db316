#pragma once

#include <rosbag/bag.h>
#include <rosbag/message_instance.h>

#include <array>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "nodelets/message_checks.h"
#include "nodelets/stamp_matcher.h"
#include "nodelets/stereo_messages.h"
#include "tools/command_line.h"

namespace predictive_stereo {

/// @throws std::runtime_error if the file cannot be read as a bag.
void openBag(const std::string& path, rosbag::Bag& bag);

/// Types of a bag's topics by name.
using TopicTypes = std::map<std::string, std::string>;
TopicTypes topicTypes(const rosbag::Bag& bag);
/// Their names, separated by commas.
std::string topicsOfType(const TopicTypes& types, const std::string& type);

/// The topics of a stereo camera in a bag. Topics of compressed images end in /compressed.
struct StereoTopics {
  std::string left, left_info, right, right_info;

  /// Those of image topics, with camera_info beside them.
  static StereoTopics ofImages(const std::string& left, const std::string& right);
  std::vector<std::string> all() const { return {left, left_info, right, right_info}; }
  /// Whether the bag has them all.
  bool areIn(const TopicTypes& types) const;
};

/// The user's choice of a camera.
struct StereoTopicChoice {
  std::string camera;       ///< namespace: <camera>/left/image_rect, ...; or empty
  std::string left, right;  ///< image topics, with camera_info in the same namespaces; or empty
  bool raw = false;         ///< images are not rectified: image_raw, not image_rect
};

/// For our odometry, where a bag fixes the camera to the default odom_frame.
constexpr char kOtherOdomFrame[] = "visual_odom";

/// The options --camera, --left, --right and --rectify.
/// @throws UsageError for a choice that is incomplete or not unique.
StereoTopicChoice topicChoice(const CommandLine& line);

/// `topic` without the suffix /compressed.
std::string imageTopic(const std::string& topic);

/// `topic`, or that of its compressed images if the bag has only these.
std::string asRecorded(const TopicTypes& types, const std::string& topic);

/// `name` with a slash before and none behind; empty: the root.
std::string cameraNamespace(std::string name);

/// Finds the chosen topics. Without a choice, those of the only camera with a known layout (see
/// findCameras), with raw images if `choice.raw`.
/// @throws std::runtime_error if a topic is missing, or without a choice if there is not exactly
///   one such camera; it lists the bag's image topics.
StereoTopics findStereoTopics(const rosbag::Bag& bag, const StereoTopicChoice& choice);

/// Messages of a bag that the nodelets would refuse: tools go on without them, as nodelets do.
class RefusedMessages {
 public:
  /// @param tell  called with the first objection of each topic.
  explicit RefusedMessages(std::function<void(const std::string&)> tell) : tell_(std::move(tell)) {}

  bool has(const std::string& topic, ros::Time stamp, ZeroStamp zero) {
    return refuses(topic, [&] { requireStamp(stamp, zero); });
  }
  bool has(const std::string& topic, const geometry_msgs::TransformStamped& transform,
           bool is_static) {
    const ZeroStamp zero = is_static ? ZeroStamp::kLegal : ZeroStamp::kRefused;
    return refuses(topic, [&] { requireTransform(transform, zero, "the bag"); });
  }
  /// Whether `use` of a message throws std::invalid_argument.
  template <class Use>
  bool refuses(const std::string& topic, const Use& use) {
    try {
      use();
    } catch (const std::invalid_argument& error) {
      if (first_.empty()) first_ = topic + ": " + error.what();
      if (counts_[topic]++ == 0) tell_(topic + ": " + error.what());
      return true;
    }
    return false;
  }

  /// The first objection of all; empty: none.
  const std::string& first() const { return first_; }
  /// Their number, for each topic that has some.
  const std::map<std::string, size_t>& counts() const { return counts_; }

 private:
  std::function<void(const std::string&)> tell_;
  std::map<std::string, size_t> counts_;
  std::string first_;
};

/// A stereo pair in a bag.
struct BagPair {
  StereoPair pair;
  /// Where its messages are, in the order of StereoTopics: readPair() reads them again.
  std::array<rosbag::MessageInstance, 4> places;
};
StereoPair readPair(const BagPair& pair);

/// Joins the messages of a camera to pairs by their stamps.
class BagPairs {
 public:
  /// @param sync  its queue size is ignored: a message waits for its partners while a thousand
  ///   others of its topic arrive.
  /// @param refused  gets the messages that nodelets would refuse.
  BagPairs(const StereoTopics& topics, SyncParams sync, RefusedMessages& refused);

  /// @param message  of any topic.
  /// @returns the pairs that it completes, oldest first.
  std::vector<BagPair> add(const rosbag::MessageInstance& message);

  /// Number of left images without partners so far.
  size_t unmatched() const { return unmatched_; }
  std::string describeMismatch() const { return matcher_.describeMismatch(); }

 private:
  std::vector<std::string> topics_;
  RefusedMessages& refused_;
  StampMatcher matcher_;
  size_t unmatched_ = 0;
};

/// The time `seconds` after `begin`, or the last one that ros::Time has: recorded times may be
/// anything, and ros::Time throws beyond.
ros::Time timeAfter(ros::Time begin, double seconds);

}  // namespace predictive_stereo
