#pragma once

#include <ros/node_handle.h>

#include <array>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>

#include "nodelets/callbacks.h"
#include "nodelets/columns_input.h"
#include "nodelets/image_subscriber.h"
#include "nodelets/moving_objects_processor.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/stamp_matcher.h"

namespace predictive_stereo {

/// Receives the outputs of the Disparity nodelet and the left image, and joins those of one stamp,
/// between start() and stop(). It can be started and stopped repeatedly.
class DisparityInput {
 public:
  using Frame = MovingObjectsInput;

  /// @param on_frame  called with each frame, from the node handle's callback queue.
  /// @param on_backward  called when stamps of left images went back, with the next one.
  DisparityInput(const ros::NodeHandle& node, Health& health,
                 const MovingObjectsNodeletParams& params,
                 std::function<void(const MovingObjectsInput&)> on_frame,
                 std::function<void(ros::Time)> on_backward);

  /// @throws std::runtime_error if the plugin of the image transport is missing.
  void start();
  /// After this has returned, neither function is called.
  void stop();

  /// Why there are no frames, and the cure; empty: frames arrive, or it is stopped.
  std::string describeMissingInput() const;
  /// Number of messages without partners.
  size_t unmatched() const;

 private:
  // The first slot has the messages that need partners. Left images do not, because not every one
  // has a disparity.
  enum Slot { kMeasured, kMeasuredVariance, kPredicted, kPredictedVariance, kLeft, kLeftInfo };
  static constexpr size_t kTopics = 6;
  struct Subscribers {
    std::array<ros::Subscriber, kTopics> others;
    ImageSubscriber left;
  };

  template <class Message>
  void add(Slot slot, const boost::shared_ptr<const Message>& message);
  MovingObjectsInput frameOf(const StampMatcher::Set& set) const;

  ros::NodeHandle node_;
  Health& health_;
  const MovingObjectsNodeletParams& params_;
  std::function<void(const MovingObjectsInput&)> on_frame_;
  std::function<void(ros::Time)> on_backward_;

  mutable std::mutex mutex_;
  StampMatcher matcher_;
  std::array<std::chrono::steady_clock::time_point, kTopics> last_received_{};
  ros::Time last_left_;
  ColumnsInput columns_;
  Subscribers subscribers_;
};

}  // namespace predictive_stereo
