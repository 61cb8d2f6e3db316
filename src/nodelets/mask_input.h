#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <atomic>
#include <mutex>
#include <opencv2/core.hpp>
#include <string>

#include "nodelets/arrivals.h"
#include "nodelets/callbacks.h"

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
  MaskInput(const ros::NodeHandle& node, Health& health, Arrivals& arrivals, Callback on_mask = {});

  /// Subscribes to this topic instead of the previous one; empty: to none. Not thread-safe.
  void listenTo(const std::string& topic);
  /// After this has returned, the callback is not called.
  void stop() { listenTo(""); }

  /// Drops the mask, because stamps went back: its stamp may occur again in the new pass of a bag.
  void forget();

  bool isPublished() const { return subscription_.isPublished(); }

  /// The mask of the frame; nullptr: not received.
  sensor_msgs::ImageConstPtr at(ros::Time stamp) const;

  /// Waits for the mask of the frame. After a timeout it does not wait again until another mask has
  /// arrived.
  sensor_msgs::ImageConstPtr waitForMask(ros::Time stamp, double timeout_s);

  /// A view of the mask as input of the core; it shares the message's memory. Empty, and a problem,
  /// if the mask cannot be used: the frame goes on without it.
  /// @param mask  may be nullptr.
  /// @param left  an image of the sequence.
  cv::Mat1b usable(const sensor_msgs::ImageConstPtr& mask, const sensor_msgs::Image& left);

 private:
  void add(const sensor_msgs::ImageConstPtr& mask);

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
