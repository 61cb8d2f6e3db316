#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/node_handle.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "nodelets/health.h"
#include "nodelets/threads.h"

namespace predictive_stereo {

/// Whether the master knows a publisher of the topic other than `node`. True, too, if its answer
/// cannot be read: to look for rivals in vain only takes some time.
/// @param system_state  the answer to getSystemState.
bool hasOtherPublisher(XmlRpc::XmlRpcValue system_state, const std::string& topic,
                       const std::string& node);

/// Finds other publishers of a frame in tf. A frame must have one parent and one publisher: with
/// two, readers of tf get their transforms alternately.
///
/// Thread-safe.
class TfRivals {
 public:
  struct Rival {
    std::string publisher;  ///< node
    std::string parent;
    bool is_static = false;
  };

  /// Call this before publishing a transform: it will be received, and must not count as a rival's.
  void addOwnTransform(const geometry_msgs::TransformStamped& transform);

  /// Adds a transform that was received from any publisher.
  void addTransform(const geometry_msgs::TransformStamped& transform, const std::string& publisher,
                    bool is_static);

  /// The rival that published last; none: no other node publishes this frame.
  std::optional<Rival> rivalOf(const std::string& frame) const;

  /// Why this node must not publish this frame in tf, and the cure; empty: it may.
  std::string reasonNotToMove(const std::string& frame) const;

 private:
  static constexpr size_t kRemembered =
      1000;  // own transforms; they are received within milliseconds

  mutable std::mutex mutex_;
  std::deque<geometry_msgs::TransformStamped> ours_;
  std::map<std::string, Rival> rivals_;  // by child
};

/// Publishes a frame in tf, unless another node does: two publishers of the same frame are worse
/// than none, so a node that finds a rival stops.
class TfOutput {
 public:
  void start(ros::NodeHandle& node);
  /// Gets every transform that is received.
  TfRivals& rivals() { return rivals_; }
  void publish(const geometry_msgs::TransformStamped& transform, Health& health,
               Arrivals& arrivals);

 private:
  bool mayPublish(const std::string& frame, Health& health, Arrivals& arrivals);

  ros::Publisher publisher_;
  TfRivals rivals_;
  std::chrono::steady_clock::time_point listening_since_;
  bool asked_ = false;    // it has waited for transforms of rivals
  bool yielded_ = false;  // it does not publish because of a rival
};

}  // namespace predictive_stereo
