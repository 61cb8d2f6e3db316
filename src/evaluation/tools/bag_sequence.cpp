#include "evaluation/tools/bag_sequence.h"

#include <nav_msgs/Odometry.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2/buffer_core.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <boost/algorithm/string/predicate.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <vector>

#include "nodelets/stereo_messages.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {
namespace {

using Topics = std::vector<std::string>;

cv::Rect2d boxOf(const MovingObject& object) {
  return {object.bbox.center.x - object.bbox.size_x / 2,
          object.bbox.center.y - object.bbox.size_y / 2, object.bbox.size_x, object.bbox.size_y};
}

Eigen::Vector3d vector(const geometry_msgs::Vector3& v) { return {v.x, v.y, v.z}; }
Eigen::Vector3d vector(const geometry_msgs::Point& p) { return {p.x, p.y, p.z}; }

// Topics of a type whose names end in `name`.
Topics topicsNamed(const rosbag::Bag& bag, const std::string& name, const std::string& type) {
  Topics found;
  for (const auto& [topic, known] : topicTypes(bag))
    if (known == type && boost::algorithm::ends_with("/" + topic, "/" + name))
      found.push_back(topic);
  return found;
}

class BagSequence : public Sequence {
 public:
  BagSequence(const std::string& path, const StereoTopicChoice& choice)
      : Sequence(std::filesystem::path(path).stem().string()) {
    openBag(path, bag_);
    topics_ = findStereoTopics(bag_, choice);
    findPairs(path);
    readTruth();
    rig_ = stereoRig(pairAt(0));
  }

  int frames() const override { return static_cast<int>(pairs_.size()); }
  double stamp_s(int index) const override { return pairAt(index).left->header.stamp.toSec(); }

  SequenceFrame frame(int index) const override {
    const StereoPair pair = pairAt(index);
    if (stereoRig(pair) != rig_)
      throw std::runtime_error(name_ + ": the calibration changes at pair " +
                               std::to_string(index) + "; split the bag there (rosbag filter)");
    SequenceFrame frame;
    frame.left = greyImage(*pair.left, "left").clone();
    frame.right = greyImage(*pair.right, "right").clone();
    return frame;
  }

 private:
  std::optional<std::vector<ObjectLabel>> trueObjects(int index) const override {
    if (truth_.empty()) return std::nullopt;
    const auto found = truth_.find(pairAt(index).left->header.stamp);
    if (found == truth_.end())
      throw std::runtime_error(name_ + ": truth/moving_objects has no message for pair " +
                               std::to_string(index));
    std::vector<ObjectLabel> labels = found->second;
    for (ObjectLabel& label : labels) label.frame = index;
    return labels;
  }

  // Stores the positions of the pairs' messages, because the images would fill the memory.
  void findPairs(const std::string& path) {
    RefusedMessages refused(
        [&](const std::string& text) { throw std::runtime_error(path + ": " + text); });
    BagPairs reader(topics_, SyncParams(), refused);
    for (const auto& message : rosbag::View(bag_, rosbag::TopicQuery(topics_.all())))
      for (BagPair& found : reader.add(message)) {
        found.pair = StereoPair();
        pairs_.push_back(found);
      }
    if (pairs_.empty())
      throw std::runtime_error(path + ": has no stereo pair on " + topics_.left + " and " +
                               topics_.right + " with their camera_info. " +
                               reader.describeMismatch());
  }

  const StereoPair& pairAt(int index) const {
    if (index != read_index_) {
      read_ = readPair(pairs_.at(static_cast<size_t>(index)));
      read_index_ = index;
    }
    return read_;
  }

  void readTruth() {
    const Topics objects =
        topicsNamed(bag_, "truth/moving_objects", "predictive_stereo/MovingObjectArray");
    const Topics odometry = topicsNamed(bag_, "truth/odometry", "nav_msgs/Odometry");
    if (objects.size() != 1 || odometry.size() != 1) return;
    tf2::BufferCore extrinsics;
    for (const auto& message : rosbag::View(bag_, rosbag::TopicQuery(Topics{"/tf_static"})))
      if (const auto tf = message.instantiate<tf2_msgs::TFMessage>())
        for (const auto& transform : tf->transforms)
          extrinsics.setTransform(transform, "bag", true);
    const std::string camera = pairAt(0).left->header.frame_id;
    std::map<ros::Time, Eigen::Matrix3d> R_odom_cam;
    for (const auto& message : rosbag::View(bag_, rosbag::TopicQuery(odometry))) {
      const auto pose = message.instantiate<nav_msgs::Odometry>();
      std::string error;
      const auto T_base_cam =
          lookUpTransform(extrinsics, pose->child_frame_id, camera, pose->header.stamp, error);
      if (!T_base_cam) throw std::runtime_error(name_ + ": truth/odometry: " + error);
      Eigen::Isometry3d T_odom_base;
      tf2::fromMsg(pose->pose.pose, T_odom_base);
      R_odom_cam[pose->header.stamp] = (T_odom_base * *T_base_cam).linear();
    }
    for (const auto& message : rosbag::View(bag_, rosbag::TopicQuery(objects))) {
      const auto array = message.instantiate<MovingObjectArray>();
      const auto R = R_odom_cam.find(array->header.stamp);
      if (R == R_odom_cam.end())
        throw std::runtime_error(name_ + ": truth/odometry has no message with stamp " +
                                 std::to_string(array->header.stamp.toSec()) +
                                 " of truth/moving_objects");
      std::vector<ObjectLabel>& labels = truth_[array->header.stamp];
      for (const MovingObject& object : array->objects)
        labels.push_back(trueObject(0, static_cast<int>(object.id), "mover", boxOf(object),
                                    object.distance, vector(object.pose.position),
                                    R->second.transpose() * vector(object.velocity), object.score));
    }
  }

  mutable rosbag::Bag bag_;  // mutable because reading changes its file position
  StereoTopics topics_;
  std::vector<BagPair> pairs_;
  std::map<ros::Time, std::vector<ObjectLabel>> truth_;
  mutable int read_index_ = -1;
  mutable StereoPair read_;
};

}  // namespace

DetectedObject detectedObject(const MovingObject& message) {
  DetectedObject object;
  object.id = static_cast<int>(message.id);
  object.box_px = boxOf(message);
  object.centre_m = vector(message.pose.position);
  object.size_m = vector(message.size);
  object.velocity_mps = vector(message.velocity);
  object.score = message.score;
  object.age = static_cast<int>(message.age);
  object.distance_m = message.distance;
  return object;
}

std::unique_ptr<Sequence> bagSequence(const std::string& path, const StereoTopicChoice& choice) {
  return std::make_unique<BagSequence>(path, choice);
}

Detector recordedDetector(const std::string& path, const Sequence& sequence) {
  rosbag::Bag bag;
  openBag(path, bag);
  Topics topics = topicsNamed(bag, "moving_objects", "predictive_stereo/MovingObjectArray");
  topics.erase(std::remove_if(topics.begin(), topics.end(),
                              [](const std::string& topic) {
                                return topic.find("truth/moving_objects") != std::string::npos;
                              }),
               topics.end());
  if (topics.size() != 1)
    throw std::runtime_error(path + ": has " + std::to_string(topics.size()) +
                             " topics .../moving_objects (predictive_stereo/MovingObjectArray): "
                             "give a bag with one");
  // Rounded to microseconds, because the stamps of a sequence are floating-point seconds.
  const auto key = [](double stamp_s) { return std::llround(stamp_s * 1e6); };
  const auto recorded = std::make_shared<std::map<long long, std::vector<DetectedObject>>>();
  for (const auto& message : rosbag::View(bag, rosbag::TopicQuery(topics))) {
    const auto array = message.instantiate<MovingObjectArray>();
    auto& objects = (*recorded)[key(array->header.stamp.toSec())];
    for (const MovingObject& object : array->objects) objects.push_back(detectedObject(object));
  }
  bool belongs = false;
  for (int index = 0; index < sequence.frames() && !belongs; ++index)
    belongs = recorded->count(key(sequence.stamp_s(index))) > 0;
  if (!belongs)
    throw std::runtime_error(path + ": " + topics[0] + " has no message with a stamp of " +
                             sequence.name() + "; was it made from this recording?");
  return [=](const StereoFrame& frame) {
    const auto found = recorded->find(key(toSeconds(frame.stamp)));
    return DetectorOutput{found == recorded->end() ? std::vector<DetectedObject>() : found->second,
                          0};
  };
}

}  // namespace predictive_stereo
