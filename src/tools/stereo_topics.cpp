#include "tools/stereo_topics.h"

#include <rosbag/view.h>

#include <map>
#include <stdexcept>
#include <vector>

#include "nodelets/compressed_image.h"

namespace predictive_stereo {
namespace {

class BagTopics {
 public:
  explicit BagTopics(const rosbag::Bag& bag) : file_(bag.getFileName()) {
    rosbag::View view(bag);
    for (const rosbag::ConnectionInfo* connection : view.getConnections())
      types_[connection->topic] = connection->datatype;
  }

  bool has(const std::string& topic, const std::string& type) const {
    const auto found = types_.find(topic);
    return found != types_.end() && found->second == type;
  }

  bool hasImages(const std::string& topic) const {
    return has(topic, "sensor_msgs/Image") ||
           (imageTopic(topic) != topic && has(topic, "sensor_msgs/CompressedImage"));
  }

  // The topic, or that of its compressed images if there are no others.
  std::string asRecorded(const std::string& topic) const {
    return !hasImages(topic) && hasImages(topic + kCompressedTopic) ? topic + kCompressedTopic
                                                                    : topic;
  }

  bool has(const StereoTopics& topics) const {
    return hasImages(topics.left) && hasImages(topics.right) &&
           has(topics.left_info, "sensor_msgs/CameraInfo") &&
           has(topics.right_info, "sensor_msgs/CameraInfo");
  }

  void requireImages(const std::string& topic) const {
    if (!hasImages(topic)) require(topic, "sensor_msgs/Image");
  }

  void require(const std::string& topic, const std::string& type) const {
    if (has(topic, type)) return;
    std::string text = file_ + " has no " + type + " on " + topic + "; topics of this type are";
    const char* separator = " ";
    for (const auto& known : types_)
      if (known.second == type) {
        text += separator + known.first;
        separator = ", ";
      }
    throw std::runtime_error(*separator == ' ' ? text + " none" : text);
  }

  std::vector<std::string> imageTopics() const {
    std::vector<std::string> result;
    for (const auto& known : types_)
      if (hasImages(known.first)) result.push_back(known.first);
    return result;
  }

 private:
  std::string file_;
  std::map<std::string, std::string> types_;
};

std::string cameraInfoTopic(const std::string& topic) {
  const std::string images = imageTopic(topic);
  const size_t slash = images.rfind('/');
  return (slash == std::string::npos ? "" : images.substr(0, slash + 1)) + "camera_info";
}

StereoTopics fromImages(const std::string& left, const std::string& right) {
  return {left, cameraInfoTopic(left), right, cameraInfoTopic(right)};
}

// Pairs of topics whose names differ only in "left" and "right".
std::vector<StereoTopics> knownLayouts(const BagTopics& bag, bool raw) {
  std::vector<StereoTopics> found;
  for (const std::string& left : bag.imageTopics()) {
    const size_t place = left.rfind("left");
    if (place == std::string::npos) continue;
    const std::string images = imageTopic(left);
    if (images != left && bag.hasImages(images)) continue;  // recorded raw and compressed
    const std::string kind = images.substr(images.rfind('/') + 1);
    const bool kitti = left.find("/camera_") != std::string::npos && kind == "image_raw";
    // KITTI's images are rectified, although they are named image_raw.
    if (raw ? kind != "image_raw" || kitti : kind != "image_rect" && !kitti) continue;
    std::string right = left;
    right.replace(place, 4, "right");
    const StereoTopics topics = fromImages(left, right);
    if (bag.has(topics)) found.push_back(topics);
  }
  return found;
}

}  // namespace

std::string imageTopic(const std::string& topic) {
  const std::string end = kCompressedTopic;
  const bool compressed =
      topic.size() > end.size() && topic.compare(topic.size() - end.size(), end.size(), end) == 0;
  return compressed ? topic.substr(0, topic.size() - end.size()) : topic;
}

sensor_msgs::ImageConstPtr imageOf(const rosbag::MessageInstance& message) {
  if (const auto image = message.instantiate<sensor_msgs::Image>()) return image;
  const auto compressed = message.instantiate<sensor_msgs::CompressedImage>();
  return compressed ? decodedImage(*compressed) : nullptr;
}

ros::Time timeAfter(ros::Time begin, double seconds) {
  const bool in_range =
      seconds < ros::DURATION_MAX.toSec() && begin.toSec() + seconds < ros::TIME_MAX.toSec();
  return in_range ? begin + ros::Duration(seconds) : ros::TIME_MAX;
}

StereoTopics findStereoTopics(const rosbag::Bag& bag, const StereoTopicChoice& choice) {
  const BagTopics known(bag);
  StereoTopics topics;
  if (!choice.camera.empty()) {
    std::string camera = choice.camera;
    while (!camera.empty() && camera.back() == '/') camera.pop_back();
    if (camera.empty() || camera[0] != '/') camera = "/" + camera;
    const std::string image = choice.raw ? "image_raw" : "image_rect";
    topics = fromImages(known.asRecorded(camera + "/left/" + image),
                        known.asRecorded(camera + "/right/" + image));
  } else if (!choice.left.empty()) {
    topics = fromImages(known.asRecorded(choice.left), known.asRecorded(choice.right));
  } else {
    const std::vector<StereoTopics> candidates = knownLayouts(known, choice.raw);
    if (candidates.size() == 1) return candidates[0];
    std::string text = candidates.empty()
                           ? bag.getFileName() + " has no stereo camera of a known layout"
                           : bag.getFileName() + " has more than one stereo camera";
    text += "; choose with --camera, or --left and --right, from these image topics:";
    for (const std::string& topic : known.imageTopics()) text += "\n  " + topic;
    if (known.imageTopics().empty()) text += " none";
    throw std::runtime_error(text);
  }
  known.requireImages(topics.left);
  known.requireImages(topics.right);
  known.require(topics.left_info, "sensor_msgs/CameraInfo");
  known.require(topics.right_info, "sensor_msgs/CameraInfo");
  return topics;
}

}  // namespace predictive_stereo
