#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>

#include <algorithm>
#include <functional>
#include <mutex>
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

/// Wakes a nodelet when its output is needed, and stops it when it is not.
class Demand {
 public:
  struct Hooks {
    std::function<bool()> wanted;
    std::function<void()> wake, sleep;
    std::function<void()> follow;  ///< called whenever demand may have changed; may be empty
    /// Runs what calls the hooks above. What they throw must end there.
    std::function<void(const std::function<void()>&)> guard;
  };

  explicit Demand(Hooks hooks) : hooks_(std::move(hooks)) {}

  /// Enables update(), and calls it.
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
    hooks_.guard([this] {
      const bool wanted = hooks_.wanted(), was_awake = std::exchange(awake_, wanted);
      if (!wanted && was_awake) hooks_.sleep();
      if (wanted && (!was_awake || failed_)) {
        failed_ = true;
        hooks_.wake();
        failed_ = false;
      }
      if (hooks_.follow) hooks_.follow();
    });
  }

  /// After this has returned, no hook is called.
  void stop() {
    const std::lock_guard<std::mutex> lock(mutex_);
    running_ = false;
  }

 private:
  const Hooks hooks_;
  std::mutex mutex_;
  bool running_ = false, awake_ = false;
  bool failed_ = false;  // to wake it: the next update tries again
};

}  // namespace predictive_stereo
