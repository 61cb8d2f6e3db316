#pragma once

#include <sensor_msgs/Image.h>

#include <opencv2/core.hpp>
#include <string>
#include <utility>

#include "nodelets/message_input.h"
#include "nodelets/stereo_messages.h"

namespace predictive_stereo {

/// Receives masks of moving objects, and waits for the mask of a given frame.
class MaskInput : public MessageInput<sensor_msgs::Image> {
 public:
  /// A subscription to this topic wakes MovingObjects.
  static constexpr const char* kTopic = "moving_objects/mask";
  /// The same masks, while another subscriber keeps MovingObjects awake; a subscription to this
  /// topic does not. Without it, two nodelets that need each other would never sleep.
  static constexpr const char* kPassiveTopic = "moving_objects/passive_mask";

  /// Keeps the newest mask only.
  MaskInput(const ros::NodeHandle& node, Health& health, Arrivals& arrivals,
            Receiver<sensor_msgs::Image> on_mask = {})
      : MessageInput(
            node, health, arrivals, [](const sensor_msgs::Image&) {}, std::move(on_mask), 1) {}

  /// See MessageInput. A mask that waits longer than one other is of no use.
  void listenTo(const std::string& topic) { MessageInput::listenTo(topic, 2); }

  /// The mask of the frame; nullptr: not received.
  sensor_msgs::ImageConstPtr at(ros::Time stamp) const { return history().of(stamp); }

  /// Waits for the mask of the frame. After a timeout it does not wait again until another mask has
  /// arrived.
  sensor_msgs::ImageConstPtr waitForMask(ros::Time stamp, double timeout_s) {
    const bool expected = isExpected();
    auto mask = arrivals_.waitFor(expected ? timeout_s : 0.0, [&] { return at(stamp); });
    if (expected && !mask) expectNone();
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
};

}  // namespace predictive_stereo
