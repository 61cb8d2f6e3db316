#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <atomic>
#include <mutex>
#include <opencv2/core.hpp>
#include <string>
#include <utility>

#include "nodelets/callbacks.h"
#include "nodelets/stereo_messages.h"
#include "nodelets/threads.h"

namespace predictive_stereo {

/// Receives masks of moving objects, and waits for the mask of a given frame.
class MaskInput {
 public:
  /// A subscription to this topic wakes MovingObjects.
  static constexpr const char* kTopic = "moving_objects/mask";
  /// The same masks, while another subscriber keeps MovingObjects awake; a subscription to this
  /// topic does not. Without it, two nodelets that need each other would never sleep.
  static constexpr const char* kPassiveTopic = "moving_objects/passive_mask";

  using Callback = Receiver<sensor_msgs::Image>;

  /// @param on_mask  called with each mask, from the node handle's callback queue.
  MaskInput(const ros::NodeHandle& node, Health& health, Arrivals& arrivals, Callback on_mask = {})
      : node_(node), health_(health), arrivals_(arrivals), on_mask_(std::move(on_mask)) {}

  /// Subscribes to this topic instead of the previous one; empty: to none. Not thread-safe.
  void listenTo(const std::string& topic) {
    if (topic == topic_) return;
    topic_ = topic;
    silent_ = false;
    if (topic.empty()) {
      subscription_.shutdown();
      return forget();
    }
    subscription_.replace(subscribe<sensor_msgs::Image>(
        node_, health_, topic, 2, [this](const sensor_msgs::ImageConstPtr& mask) { add(mask); }));
  }

  /// After this has returned, the callback is not called.
  void stop() { listenTo(""); }

  /// Drops the mask, because stamps went back: its stamp may occur again in the new pass of a bag.
  void forget() {
    const std::lock_guard<std::mutex> lock(mutex_);
    mask_.reset();
  }

  bool isPublished() const { return subscription_.isPublished(); }

  /// The mask of the frame; nullptr: not received.
  sensor_msgs::ImageConstPtr at(ros::Time stamp) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return mask_ && mask_->header.stamp == stamp ? mask_ : nullptr;
  }

  /// Waits for the mask of the frame. After a timeout it does not wait again until another mask has
  /// arrived.
  sensor_msgs::ImageConstPtr waitForMask(ros::Time stamp, double timeout_s) {
    const bool expected = isPublished() && !silent_;
    auto mask = arrivals_.waitFor(expected ? timeout_s : 0.0, [&] { return at(stamp); });
    if (expected && !mask) silent_ = true;
    return mask;
  }

  /// A view of the mask as input of the core; it shares the message's memory. Empty, and a problem,
  /// if the mask cannot be used: the frame goes on without it.
  /// @param mask  may be nullptr.
  /// @param left  an image of the sequence.
  cv::Mat1b usable(const sensor_msgs::ImageConstPtr& mask, const sensor_msgs::Image& left) {
    cv::Mat1b view;
    if (mask) health_.guard(kTopic, [&] { view = movedMask(*mask, left); });
    return view;
  }

 private:
  void add(const sensor_msgs::ImageConstPtr& mask) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      mask_ = mask;
    }
    silent_ = false;
    arrivals_.notify();
    if (on_mask_) on_mask_(mask);
  }

  ros::NodeHandle node_;
  Health& health_;
  Arrivals& arrivals_;
  Callback on_mask_;
  std::string topic_;
  mutable std::mutex mutex_;
  sensor_msgs::ImageConstPtr mask_;
  std::atomic<bool> silent_{false};
  Subscription subscription_;
};

}  // namespace predictive_stereo
