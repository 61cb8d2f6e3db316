#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <utility>

#include "nodelets/tf_input.h"

namespace predictive_stereo {

/// The newest mask of moving objects, and the wait for that of a certain frame.
class MaskInput {
 public:
  using Callback = std::function<void(const sensor_msgs::ImageConstPtr&)>;

  /// @param on_mask  called with each mask, from the node handle's callback queue.
  explicit MaskInput(const ros::NodeHandle& node, Callback on_mask = {})
      : node_(node), on_mask_(std::move(on_mask)) {}

  void start() {
    subscriber_ = node_.subscribe<sensor_msgs::Image>(
        "moving_objects/mask", 2, [this](const sensor_msgs::ImageConstPtr& mask) { add(mask); });
  }
  /// No more calls once this has returned.
  void stop() {
    subscriber_.shutdown();
    forget();
  }

  /// Stamps went back: what was received is of another pass, though its stamp may come again.
  void forget() {
    const std::lock_guard<std::mutex> lock(mutex_);
    mask_.reset();
  }

  bool isStarted() const { return static_cast<bool>(subscriber_); }
  bool isPublished() const { return subscriber_.getNumPublishers() > 0; }

  /// The mask of the frame; null where it has not come.
  sensor_msgs::ImageConstPtr at(ros::Time stamp) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return mask_ && mask_->header.stamp == stamp ? mask_ : nullptr;
  }

  /// The same, having waited for it. Whoever fails to send one is not waited for again before it
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
  mutable std::mutex mutex_;
  sensor_msgs::ImageConstPtr mask_;
  std::atomic<bool> silent_{false};
  ros::Subscriber subscriber_;
};

}  // namespace predictive_stereo
