#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/node_handle.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "nodelets/health.h"
#include "nodelets/threads.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {

/// Publishes frames in tf, unless another node does. A frame must have one parent and one
/// publisher: with two, readers of tf get their transforms alternately. That is worse than none, so
/// a node that finds such a rival stops.
class TfOutput {
 public:
  void start(ros::NodeHandle& node) {
    listening_since_ = std::chrono::steady_clock::now();
    publisher_ = node.advertise<tf2_msgs::TFMessage>("/tf", 100);
  }

  void publish(const geometry_msgs::TransformStamped& transform, Health& health,
               Arrivals& arrivals) {
    if (yielded_) return;
    waitForRivalOnce(transform.child_frame_id, arrivals);
    const std::string objection = reasonNotToMove(transform.child_frame_id);
    health.problem("tf", objection);
    yielded_ = !objection.empty();
    if (yielded_) return;
    addOwnTransform(transform);
    const auto message = boost::make_shared<tf2_msgs::TFMessage>();
    message->transforms.push_back(transform);
    publisher_.publish(message);
  }

  /// Adds a transform before it is published: it will be received, and must not count as a rival's.
  void addOwnTransform(const geometry_msgs::TransformStamped& transform) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ours_.push_back(transform);
    if (ours_.size() > kRemembered) ours_.pop_front();
  }

  /// Adds a transform that was received from any publisher; from any thread.
  void addTransform(const geometry_msgs::TransformStamped& transform, const std::string& publisher,
                    bool is_static) {
    const std::lock_guard<std::mutex> lock(mutex_);
    // Backwards, because the newest ones are at the end.
    if (!is_static && std::find(ours_.rbegin(), ours_.rend(), transform) != ours_.rend()) return;
    const std::string &child = transform.child_frame_id, &parent = transform.header.frame_id;
    rivals_[withoutSlash(child)] = {publisher, withoutSlash(parent), is_static};
    if (is_static) fixed_.add(child, parent);
  }

  /// Why this node must not publish this frame in tf, and the cure; empty: it may.
  std::string reasonNotToMove(const std::string& frame) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = rivals_.find(withoutSlash(frame));
    if (found == rivals_.end()) return "";
    const Rival& rival = found->second;
    const std::string silent = ": tf is not published from here, as a frame has one parent only. ";
    if (!rival.is_static)
      return "tf: " + rival.publisher + " already moves '" + frame + "' in '" + rival.parent + "'" +
             silent +
             "To use that motion, launch with ego_motion:=false odom_frame:=" + rival.parent +
             "; to use this one, stop the other and restart this nodelet";
    return "tf: " + rival.publisher + " has '" + frame + "' fixed to '" + rival.parent + "'" +
           silent + "Set base_frame to '" + fixed_.rootOf(frame) + "', or publish_tf to false";
  }

 private:
  // The node that published a frame last.
  struct Rival {
    std::string publisher, parent;
    bool is_static = false;
  };

  static constexpr double kFirstWithin_s = 0.5;  // rivals are assumed to publish at 2 Hz or more
  static constexpr size_t kRemembered = 1000;    // they are received within milliseconds

  void waitForRivalOnce(const std::string& frame, Arrivals& arrivals) {
    if (std::exchange(waited_, true)) return;
    const std::chrono::duration<double> listened =
        std::chrono::steady_clock::now() - listening_since_;
    arrivals.waitFor(kFirstWithin_s - listened.count(),
                     [&] { return !reasonNotToMove(frame).empty(); });
  }

  ros::Publisher publisher_;
  std::chrono::steady_clock::time_point listening_since_;
  bool waited_ = false;   // for transforms of rivals
  bool yielded_ = false;  // it does not publish because of a rival
  mutable std::mutex mutex_;
  std::deque<geometry_msgs::TransformStamped> ours_;
  std::map<std::string, Rival> rivals_;  // by child
  FixedFrames fixed_;
};

}  // namespace predictive_stereo
