#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace predictive_stereo {

/// Output topics of a nodelet, with notification of subscribers.
class Outputs {
 public:
  /// @param changed  called when a subscriber was added or removed, from the callback queue of the
  ///   node handle that advertised the topic.
  explicit Outputs(std::function<void()> changed) : changed_(std::move(changed)) {}

  template <class Message>
  ros::Publisher advertise(ros::NodeHandle& node, const std::string& topic, uint32_t queue) {
    const auto connect = [this](const ros::SingleSubscriberPublisher&) { changed_(); };
    topics_.push_back(node.advertise<Message>(topic, queue, connect, connect));
    return topics_.back();
  }
  image_transport::Publisher advertiseImage(const ros::NodeHandle& node, const std::string& topic,
                                            uint32_t queue) {
    const auto connect = [this](const image_transport::SingleSubscriberPublisher&) { changed_(); };
    images_.push_back(
        image_transport::ImageTransport(node).advertise(topic, queue, connect, connect));
    return images_.back();
  }

  bool wanted() const {
    const auto listened = [](const auto& topic) { return topic.getNumSubscribers() > 0; };
    return std::any_of(topics_.begin(), topics_.end(), listened) ||
           std::any_of(images_.begin(), images_.end(), listened);
  }

 private:
  std::function<void()> changed_;
  std::vector<ros::Publisher> topics_;
  std::vector<image_transport::Publisher> images_;
};

}  // namespace predictive_stereo
