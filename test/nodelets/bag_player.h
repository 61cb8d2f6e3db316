#pragma once

#include <ros/ros.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include <boost/make_shared.hpp>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "nodelets/stereo_messages.h"
#include "recorder.h"
#include "tools/stereo_bag.h"

namespace predictive_stereo {

/// Plays the stereo camera of a bag, and its /tf_static, on the bag's topics. Each pair waits until
/// the previous one has been processed, so results do not depend on the machine's speed.
class BagPlayer {
 public:
  explicit BagPlayer(const std::string& path) {
    bag_.open(path, rosbag::bagmode::Read);
    topics_ = findStereoTopics(bag_, {});
    left_ = node_.advertise<sensor_msgs::Image>(topics_.left, 20);
    right_ = node_.advertise<sensor_msgs::Image>(topics_.right, 20);
    left_info_ = node_.advertise<sensor_msgs::CameraInfo>(topics_.left_info, 20);
    right_info_ = node_.advertise<sensor_msgs::CameraInfo>(topics_.right_info, 20);
    tf_static_ = node_.advertise<tf2_msgs::TFMessage>("/tf_static", 1, true);
    for (const auto& message : view({topics_.left}))
      stamps_.push_back(message.instantiate<sensor_msgs::Image>()->header.stamp);
  }

  const std::vector<ros::Time>& stamps() const { return stamps_; }
  const rosbag::Bag& bag() const { return bag_; }

  /// The bag's static transforms, without repetitions.
  tf2_msgs::TFMessage staticTransforms() const {
    std::map<std::string, geometry_msgs::TransformStamped> by_child;
    for (const auto& message : view({"/tf_static"})) {
      const auto tf = message.instantiate<tf2_msgs::TFMessage>();
      for (const auto& transform : tf->transforms)
        by_child.emplace(transform.child_frame_id, transform);
    }
    tf2_msgs::TFMessage all;
    for (const auto& transform : by_child) all.transforms.push_back(transform.second);
    return all;
  }
  void publishStaticTransforms() { tf_static_.publish(staticTransforms()); }

  /// @param processes  number of processes that subscribe to the left camera.
  bool waitForSubscribers(uint32_t processes) {
    return eventually([&] {
      return left_.getNumSubscribers() >= processes &&
             left_info_.getNumSubscribers() >= processes && right_.getNumSubscribers() > 0 &&
             right_info_.getNumSubscribers() > 0;
    });
  }

  /// @param dealt_with  waits until all outputs for the pair with this stamp have arrived.
  void play(size_t pairs, const std::function<void(ros::Time)>& dealt_with) {
    ros::Time waiting;
    size_t played = 0;
    for (const auto& message :
         view({topics_.left, topics_.left_info, topics_.right, topics_.right_info})) {
      const std::string& topic = message.getTopic();
      if (topic == topics_.left) {
        if (!waiting.isZero()) dealt_with(waiting);
        waiting = ros::Time();
        if (played++ == pairs) return;
        const auto image = message.instantiate<sensor_msgs::Image>();
        waiting = image->header.stamp;
        left_.publish(image);
      } else if (topic == topics_.right) {
        right_.publish(message.instantiate<sensor_msgs::Image>());
      } else {
        (topic == topics_.left_info ? left_info_ : right_info_)
            .publish(message.instantiate<sensor_msgs::CameraInfo>());
      }
    }
    if (!waiting.isZero()) dealt_with(waiting);
  }

 private:
  rosbag::View view(const std::vector<std::string>& topics) const {
    return rosbag::View(bag_, rosbag::TopicQuery(topics));
  }

  ros::NodeHandle node_;
  rosbag::Bag bag_;
  StereoTopics topics_;
  std::vector<ros::Time> stamps_;
  ros::Publisher left_, right_, left_info_, right_info_, tf_static_;
};

}  // namespace predictive_stereo
