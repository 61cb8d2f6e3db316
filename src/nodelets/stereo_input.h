#pragma once

#include <image_transport/image_transport.h>
#include <image_transport/subscriber.h>
#include <ros/node_handle.h>

#include <array>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>

#include "nodelets/stamp_matcher.h"
#include "nodelets/stereo_messages.h"

namespace predictive_stereo {

/// The four topics of a stereo camera, joined into pairs between start() and stop().
class StereoInput {
 public:
  /// @param on_pair  called with each pair, from the node handle's callback queue.
  /// @param on_backward  called with the stamp of the first pair after the stamps went back,
  ///   before it.
  StereoInput(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
              const SyncParams& params, std::function<void(const StereoPair&)> on_pair,
              std::function<void(ros::Time)> on_backward);

  void start();

  /// No more calls of either function once this has returned.
  void stop();

  /// Why no pairs come, and which parameter cures it; empty where they do.
  std::string silence() const;

  /// Left images that found no partner.
  size_t unmatched() const;

 private:
  static constexpr size_t kTopics = 4;

  template <class Message>
  void add(size_t slot, const boost::shared_ptr<const Message>& message, bool may_be_constant);

  ros::NodeHandle node_, private_node_;
  const uint32_t queue_;
  std::function<void(const StereoPair&)> on_pair_;
  std::function<void(ros::Time)> on_backward_;

  mutable std::mutex mutex_;
  StampMatcher matcher_;
  std::array<std::chrono::steady_clock::time_point, kTopics> last_received_{};
  ros::Time last_stamp_;

  image_transport::ImageTransport transport_;
  image_transport::Subscriber left_, right_;
  ros::Subscriber left_info_, right_info_;
};

}  // namespace predictive_stereo
