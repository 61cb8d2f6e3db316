#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace predictive_stereo {

/// Topics of which a nodelet wants to know whether anybody listens to one of them.
class Outputs {
 public:
  /// @param changed  called when a subscriber has come or gone, from the callback queue of the node
  ///   handle that a topic was advertised with.
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

/// What a nodelet does while somebody needs it, and not otherwise.
class Demand {
 public:
  struct Hooks {
    std::function<bool()> wanted;
    std::function<void()> wake, sleep;
    std::function<void()> follow;  ///< called whenever demand may have changed; may be empty
    std::function<void(const std::exception&)> failed;  ///< one of those above threw
  };

  explicit Demand(Hooks hooks) : hooks_(std::move(hooks)) {}

  /// From now on update() calls the hooks. Calls it.
  void start() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      running_ = true;
    }
    update();
  }

  /// Wakes or stops the nodelet, if the demand has changed.
  void update() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!running_) return;
    try {
      const bool wanted = hooks_.wanted(), was_awake = std::exchange(awake_, wanted);
      if (wanted && !was_awake) hooks_.wake();
      if (!wanted && was_awake) hooks_.sleep();
      if (hooks_.follow) hooks_.follow();
    } catch (const std::exception& e) {
      hooks_.failed(e);
    }
  }

  /// No more calls of the hooks once this has returned.
  void stop() {
    const std::lock_guard<std::mutex> lock(mutex_);
    running_ = false;
  }

 private:
  const Hooks hooks_;
  std::mutex mutex_;
  bool running_ = false, awake_ = false;
};

}  // namespace predictive_stereo
