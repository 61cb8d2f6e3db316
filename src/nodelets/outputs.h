#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <algorithm>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace predictive_stereo {

struct OutputTopic {
  std::string name;
  uint32_t queue = 5;
  bool by_image_transport = false;  ///< for viewers: also as JPEG or PNG
};

/// Topics to which each frame gives a message, made only while they have subscribers.
template <class Frame>
class Outputs {
 public:
  /// @param changed  called when a subscriber was added or removed, from the callback queue of the
  ///   node handle.
  Outputs(const ros::NodeHandle& node, std::function<void()> changed)
      : node_(node), changed_(std::move(changed)) {}

  /// Adds a topic.
  /// @param make  gives a pointer to the message of a Frame, or nullptr: a member or a function.
  template <class Make>
  void operator()(const OutputTopic& topic, const Make& make) {
    using Message = std::decay_t<decltype(*std::invoke(make, std::declval<const Frame&>()))>;
    const auto changed = [this](const auto&) { changed_(); };
    if constexpr (std::is_same_v<Message, sensor_msgs::Image>)
      if (topic.by_image_transport)
        return add(topic.name,
                   image_transport::ImageTransport(node_).advertise(topic.name, topic.queue,
                                                                    changed, changed),
                   make);
    add(topic.name, node_.advertise<Message>(topic.name, topic.queue, changed, changed), make);
  }

  bool wanted() const {
    return std::any_of(topics_.begin(), topics_.end(), [](const Topic& t) { return t.wanted(); });
  }
  bool wanted(const std::string& name) const {
    return std::any_of(topics_.begin(), topics_.end(),
                       [&](const Topic& t) { return t.name == name && t.wanted(); });
  }

  /// In the order in which the topics were added.
  void publish(const Frame& frame) const {
    for (const Topic& topic : topics_) topic.publish(frame);
  }

 private:
  struct Topic {
    std::string name;
    std::function<bool()> wanted;
    std::function<void(const Frame&)> publish;
  };

  template <class Publisher, class Make>
  void add(const std::string& name, const Publisher& publisher, const Make& make) {
    const auto wanted = [publisher] { return publisher.getNumSubscribers() > 0; };
    topics_.push_back({name, wanted, [=](const Frame& frame) {
                         if (!wanted()) return;
                         if (const auto message = std::invoke(make, frame))
                           publisher.publish(message);
                       }});
  }

  ros::NodeHandle node_;
  std::function<void()> changed_;
  std::vector<Topic> topics_;
};

}  // namespace predictive_stereo
