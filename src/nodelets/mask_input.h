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

/// Receives masks of moving objects, and waits for the mask of a given frame.
class MaskInput {
 public:
  /// A subscription to this topic wakes MovingObjects.
  static constexpr const char* kTopic = "moving_objects/mask";
  /// The same masks, while another subscriber keeps MovingObjects awake; a subscription to this
  /// topic does not. Without it, two nodelets that need each other would never sleep.
  static constexpr const char* kPassiveTopic = "moving_objects/passive_mask";

  using Callback = std::function<void(const sensor_msgs::ImageConstPtr&)>;

  /// @param on_mask  called with each mask, from the node handle's callback queue.
  explicit MaskInput(const ros::NodeHandle& node, Callback on_mask = {})
      : node_(node), on_mask_(std::move(on_mask)) {}

  /// Subscribes to this topic instead of the previous one; empty: to none. Not thread-safe.
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
    subscriber.shutdown();  // without the lock: it waits for callbacks, and these take the lock
    if (topic.empty()) forget();
  }
  /// After this has returned, the callback is not called.
  void stop() { listenTo(""); }

  /// Drops the mask, because stamps went back: its stamp may occur again in the new pass of a bag.
  void forget() {
    const std::lock_guard<std::mutex> lock(mutex_);
    mask_.reset();
  }

  bool isPublished() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return subscriber_.getNumPublishers() > 0;
  }

  /// The mask of the frame; nullptr: not received.
  sensor_msgs::ImageConstPtr at(ros::Time stamp) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return mask_ && mask_->header.stamp == stamp ? mask_ : nullptr;
  }

  /// Waits for the mask of the frame. After a timeout it does not wait again until another mask has
  /// arrived.
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
