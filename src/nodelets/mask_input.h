#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <utility>

#include "nodelets/tf_input.h"

namespace predictive_stereo {

/// The newest mask of moving objects, and the wait for that of a certain frame.
class MaskInput {
 public:
  /// Subscribing to this wakes MovingObjects.
  static constexpr const char* kTopic = "moving_objects/mask";
  /// The same masks, as long as somebody else keeps MovingObjects awake: subscribing to this does
  /// not. Without it two nodelets that need each other would never sleep.
  static constexpr const char* kPassiveTopic = "moving_objects/passive_mask";

  using Callback = std::function<void(const sensor_msgs::ImageConstPtr&)>;

  /// @param on_mask  called with each mask, from the node handle's callback queue.
  explicit MaskInput(const ros::NodeHandle& node, Callback on_mask = {})
      : node_(node), on_mask_(std::move(on_mask)) {}

  /// Takes masks from this topic alone; empty: from none. Not to be called by two threads at once.
  void listenTo(const std::string& topic) {
    if (topic == topic_) return;
    topic_ = topic;
    silent_ = false;
    ros::Subscriber subscriber;
    if (!topic.empty())
      subscriber = node_.subscribe<sensor_msgs::Image>(
          topic, 2, [this](const sensor_msgs::ImageConstPtr& mask) { add(mask); });
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      std::swap(subscriber, subscriber_);
    }
    subscriber.shutdown();  // without the lock, which the callback that this waits for takes
    if (topic.empty()) forget();
  }
  /// No more calls once this has returned.
  void stop() { listenTo(""); }

  /// Stamps went back: what was received is of another pass, though its stamp may come again.
  void forget() {
    const std::lock_guard<std::mutex> lock(mutex_);
    mask_.reset();
  }

  bool isPublished() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return subscriber_.getNumPublishers() > 0;
  }

  /// The mask of the frame; null where it has not come.
  sensor_msgs::ImageConstPtr at(ros::Time stamp) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return mask_ && mask_->header.stamp == stamp ? mask_ : nullptr;
  }

  /// The same, having waited for it. A sender that failed once is not waited for again before it
  /// has sent another.
  sensor_msgs::ImageConstPtr waitForMask(ros::Time stamp, double timeout_s) {
    const bool expected = isPublished() && !silent_;
    auto mask = waitFor(expected ? timeout_s : 0.0, [&] { return at(stamp); });
    if (expected && !mask) silent_ = true;
    return mask;
  }

 private:
  void add(const sensor_msgs::ImageConstPtr& mask) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      mask_ = mask;
    }
    silent_ = false;
    if (on_mask_) on_mask_(mask);
  }

  ros::NodeHandle node_;
  Callback on_mask_;
  std::string topic_;
  mutable std::mutex mutex_;
  sensor_msgs::ImageConstPtr mask_;
  std::atomic<bool> silent_{false};
  ros::Subscriber subscriber_;
};

}  // namespace predictive_stereo
