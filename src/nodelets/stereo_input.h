#pragma once

#include <ros/node_handle.h>

#include <array>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>

#include "nodelets/image_subscriber.h"
#include "nodelets/stamp_matcher.h"
#include "nodelets/stereo_messages.h"

namespace predictive_stereo {

/// Receives the four topics of a stereo camera and joins them into pairs, between start() and
/// stop(). It can be started and stopped repeatedly.
class StereoInput {
 public:
  using Frame = StereoPair;

  /// @param health  gets what is refused of each topic.
  /// @param on_pair  called with each pair, from the node handle's callback queue.
  /// @param on_backward  called when stamps went back, with the stamp of the next pair, before that
  ///   pair.
  StereoInput(const ros::NodeHandle& node, Health& health, const SyncParams& params,
              std::function<void(const StereoPair&)> on_pair,
              std::function<void(ros::Time)> on_backward);

  /// @throws std::runtime_error if the plugin of the image transport is missing.
  void start();

  /// After this has returned, neither function is called.
  void stop();

  /// Why there are no pairs, and which parameter is the cure; empty: pairs arrive, or it is
  /// stopped.
  std::string describeMissingInput() const;

  /// Number of left images without a partner.
  size_t unmatched() const;

 private:
  static constexpr size_t kTopics = 4;

  template <class Message>
  void add(size_t slot, const boost::shared_ptr<const Message>& message, bool may_be_constant);

  ros::NodeHandle node_;
  Health& health_;
  const std::string transport_;
  const uint32_t queue_;
  std::function<void(const StereoPair&)> on_pair_;
  std::function<void(ros::Time)> on_backward_;

  mutable std::mutex mutex_;
  StampMatcher matcher_;
  std::array<std::chrono::steady_clock::time_point, kTopics> last_received_{};
  ros::Time last_stamp_;

  struct Subscribers {
    ImageSubscriber left, right;
    ros::Subscriber left_info, right_info;
  };
  Subscribers subscribers_;
};

}  // namespace predictive_stereo
