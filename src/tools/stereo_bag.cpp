#include "tools/stereo_bag.h"

#include <rosbag/view.h>

#include <algorithm>
#include <boost/algorithm/string/predicate.hpp>
#include <boost/make_shared.hpp>
#include <cstring>
#include <optional>

#include "tools/bag_check.h"

namespace predictive_stereo {
namespace {

bool hasType(const TopicTypes& types, const std::string& topic, const std::string& type) {
  const auto found = types.find(topic);
  return found != types.end() && found->second == type;
}

bool hasImages(const TopicTypes& types, const std::string& topic) {
  return hasType(types, topic, "sensor_msgs/Image") ||
         (imageTopic(topic) != topic && hasType(types, topic, "sensor_msgs/CompressedImage"));
}

void require(const rosbag::Bag& bag, const TopicTypes& types, const std::string& topic,
             const std::string& type) {
  if (hasType(types, topic, type)) return;
  const std::string known = topicsOfType(types, type);
  throw std::runtime_error(bag.getFileName() + " has no " + type + " on " + topic +
                           "; topics of this type are " + (known.empty() ? "none" : known));
}

std::vector<std::string> topicsWithImages(const TopicTypes& types) {
  std::vector<std::string> result;
  for (const auto& known : types)
    if (hasImages(types, known.first)) result.push_back(known.first);
  return result;
}

std::string cameraInfoTopic(const std::string& topic) {
  const std::string images = imageTopic(topic);
  const size_t slash = images.rfind('/');
  return (slash == std::string::npos ? "" : images.substr(0, slash + 1)) + "camera_info";
}

// One per camera.
std::vector<StereoTopics> knownCameras(const TopicTypes& types, bool raw) {
  std::vector<StereoTopics> found;
  for (const CameraLayout& layout : findCameras(types)) {
    const auto is_same = [&](const StereoTopics& other) {
      return other.left_info == layout.topics.left_info;
    };
    if (layout.is_raw == raw && std::none_of(found.begin(), found.end(), is_same))
      found.push_back(layout.topics);
  }
  return found;
}

// The image of a sensor_msgs/Image, or the decoded image of a sensor_msgs/CompressedImage; nullptr
// for other messages.
sensor_msgs::ImageConstPtr imageOf(const rosbag::MessageInstance& message) {
  if (const auto image = message.instantiate<sensor_msgs::Image>()) return image;
  const auto compressed = message.instantiate<sensor_msgs::CompressedImage>();
  return compressed ? decodedImage(*compressed) : nullptr;
}

// The stamp of an image, or of a calibration; none: the message is another one.
std::optional<ros::Time> recordedStamp(const rosbag::MessageInstance& message, bool is_image) {
  if (!is_image) {
    const auto info = message.instantiate<sensor_msgs::CameraInfo>();
    return info ? std::optional(info->header.stamp) : std::nullopt;
  }
  if (const auto image = message.instantiate<sensor_msgs::Image>()) return image->header.stamp;
  const auto packed = message.instantiate<sensor_msgs::CompressedImage>();
  return packed ? std::optional(packed->header.stamp) : std::nullopt;
}

enum Slot { kLeft, kLeftInfo, kRight, kRightInfo };

SyncParams withoutLimit(SyncParams sync) {
  sync.queue_size = 1000;
  return sync;
}

}  // namespace

void openBag(const std::string& path, rosbag::Bag& bag) {
  try {
    bag.open(path, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw std::runtime_error(path +
                             ": has no index (was the recording cut off?); run rosbag reindex");
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(path + ": cannot be read as a bag (" + error.what() + ")");
  }
}

TopicTypes topicTypes(const rosbag::Bag& bag) {
  TopicTypes types;
  rosbag::View view(bag);
  for (const rosbag::ConnectionInfo* connection : view.getConnections())
    types[connection->topic] = connection->datatype;
  return types;
}

std::string topicsOfType(const TopicTypes& types, const std::string& type) {
  std::string list;
  for (const auto& known : types)
    if (known.second == type) list += (list.empty() ? "" : ", ") + known.first;
  return list;
}

StereoTopics StereoTopics::ofImages(const std::string& left, const std::string& right) {
  return {left, cameraInfoTopic(left), right, cameraInfoTopic(right)};
}

bool StereoTopics::areIn(const TopicTypes& types) const {
  return hasImages(types, left) && hasImages(types, right) &&
         hasType(types, left_info, "sensor_msgs/CameraInfo") &&
         hasType(types, right_info, "sensor_msgs/CameraInfo");
}

StereoTopicChoice topicChoice(const CommandLine& line) {
  const StereoTopicChoice choice{line.get("camera"), line.get("left"), line.get("right"),
                                 line.has("rectify")};
  if (choice.left.empty() != choice.right.empty())
    throw UsageError("give --left and --right together");
  if (!choice.left.empty() && !choice.camera.empty())
    throw UsageError("give either --camera, or --left and --right, not both");
  return choice;
}

std::string asRecorded(const TopicTypes& types, const std::string& topic) {
  return !hasImages(types, topic) && hasImages(types, topic + kCompressedTopic)
             ? topic + kCompressedTopic
             : topic;
}

std::string cameraNamespace(std::string name) {
  while (!name.empty() && name.back() == '/') name.pop_back();
  return name.empty() || name[0] == '/' ? name : "/" + name;
}

std::string imageTopic(const std::string& topic) {
  return boost::algorithm::ends_with(topic, kCompressedTopic)
             ? topic.substr(0, topic.size() - std::strlen(kCompressedTopic))
             : topic;
}

ros::Time timeAfter(ros::Time begin, double seconds) {
  const bool in_range =
      seconds < ros::DURATION_MAX.toSec() && begin.toSec() + seconds < ros::TIME_MAX.toSec();
  return in_range ? begin + ros::Duration(seconds) : ros::TIME_MAX;
}

StereoTopics findStereoTopics(const rosbag::Bag& bag, const StereoTopicChoice& choice) {
  const TopicTypes types = topicTypes(bag);
  StereoTopics topics;
  if (!choice.camera.empty()) {
    const std::string camera = cameraNamespace(choice.camera);
    const std::string image = choice.raw ? "image_raw" : "image_rect";
    topics = StereoTopics::ofImages(asRecorded(types, camera + "/left/" + image),
                                    asRecorded(types, camera + "/right/" + image));
  } else if (!choice.left.empty()) {
    topics =
        StereoTopics::ofImages(asRecorded(types, choice.left), asRecorded(types, choice.right));
  } else {
    const std::vector<StereoTopics> candidates = knownCameras(types, choice.raw);
    if (candidates.size() == 1) return candidates[0];
    std::string text = candidates.empty()
                           ? bag.getFileName() + " has no stereo camera of a known layout"
                           : bag.getFileName() + " has more than one stereo camera";
    if (candidates.empty() && !choice.raw && !knownCameras(types, true).empty())
      text += " but with raw images (replay takes them by --rectify)";
    text += "; choose with --camera, or --left and --right, from these image topics:";
    for (const std::string& topic : topicsWithImages(types)) text += "\n  " + topic;
    if (topicsWithImages(types).empty()) text += " none";
    throw std::runtime_error(text);
  }
  for (const std::string& images : {topics.left, topics.right})
    if (!hasImages(types, images)) require(bag, types, images, "sensor_msgs/Image");
  require(bag, types, topics.left_info, "sensor_msgs/CameraInfo");
  require(bag, types, topics.right_info, "sensor_msgs/CameraInfo");
  return topics;
}

StereoPair readPair(const BagPair& pair) {
  return {imageOf(pair.places[kLeft]), imageOf(pair.places[kRight]),
          pair.places[kLeftInfo].instantiate<sensor_msgs::CameraInfo>(),
          pair.places[kRightInfo].instantiate<sensor_msgs::CameraInfo>()};
}

BagPairs::BagPairs(const StereoTopics& topics, SyncParams sync, RefusedMessages& refused)
    : topics_(topics.all()), refused_(refused), matcher_(topics_, withoutLimit(sync)) {}

std::vector<BagPair> BagPairs::add(const rosbag::MessageInstance& message) {
  const std::string& topic = message.getTopic();
  const auto place = std::find(topics_.begin(), topics_.end(), topic);
  if (place == topics_.end()) return {};
  const auto slot = static_cast<size_t>(place - topics_.begin());
  const bool is_image = slot == kLeft || slot == kRight;
  const std::optional<ros::Time> stamp = recordedStamp(message, is_image);
  if (!stamp || refused_.has(topic, *stamp, is_image ? ZeroStamp::kRefused : ZeroStamp::kLegal))
    return {};
  if (slot == kLeft) ++unmatched_;
  std::vector<BagPair> pairs;
  // Only places wait: a thousand images would need gigabytes.
  for (const StampMatcher::Set& set :
       matcher_.add(slot, *stamp, boost::make_shared<const rosbag::MessageInstance>(message),
                    stamp->isZero())) {
    --unmatched_;
    const auto at = [&](Slot s) -> const rosbag::MessageInstance& {
      return *static_cast<const rosbag::MessageInstance*>(set[s].get());
    };
    BagPair found{{}, {at(kLeft), at(kLeftInfo), at(kRight), at(kRightInfo)}};
    const auto read = [&](Slot s, sensor_msgs::ImageConstPtr& image) {
      return !refused_.refuses(topics_[s], [&] { image = imageOf(at(s)); });
    };
    if (!read(kLeft, found.pair.left) || !read(kRight, found.pair.right)) continue;
    found.pair.left_info = at(kLeftInfo).instantiate<sensor_msgs::CameraInfo>();
    found.pair.right_info = at(kRightInfo).instantiate<sensor_msgs::CameraInfo>();
    pairs.push_back(std::move(found));
  }
  return pairs;
}

}  // namespace predictive_stereo
