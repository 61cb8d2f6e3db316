#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>

#include <atomic>

#include "nodelets/arrivals.h"
#include "nodelets/callbacks.h"
#include "nodelets/message_checks.h"
#include "nodelets/motion_source.h"

namespace predictive_stereo {

/// Receives odometry, and waits for that of a given frame.
class OdometryInput {
 public:
  OdometryInput(const ros::NodeHandle& node, Health& health, Arrivals& arrivals)
      : node_(node), health_(health), arrivals_(arrivals) {}

  void start() {
    subscription_.replace(subscribe<nav_msgs::Odometry>(
        node_, health_, "odometry", 50, [this](const nav_msgs::OdometryConstPtr& odometry) {
          requireOdometry(*odometry);
          history_.add(odometry);
          silent_ = false;
          arrivals_.notify();
        }));
  }
  /// After this has returned, nothing is received.
  void stop() {
    subscription_.shutdown();
    history_.clear();
    silent_ = false;
  }
  void goBackTo(ros::Time stamp) { history_.goBackTo(stamp); }

  /// Calls `ask` after each arrival until its answer is complete or timeout_s has passed. After a
  /// timeout with a usable answer, it does not wait again until odometry has arrived.
  /// @param ask  gives a MotionAnswer or PoseAnswer from an OdometryHistory; from nullptr if there
  /// is
  ///   nothing to wait for.
  template <class Ask>
  auto waitFor(double timeout_s, const Ask& ask) {
    decltype(ask(nullptr)) answer;
    const bool complete = arrivals_.waitFor(timeout_s, [&] {
      const bool listen = subscription_.isPublished() && !silent_;
      answer = ask(listen ? &history_ : nullptr);
      return answer.complete;
    });
    if (answer.known() && !complete) silent_ = true;
    return answer;
  }

 private:
  ros::NodeHandle node_;
  Health& health_;
  Arrivals& arrivals_;
  OdometryHistory history_;
  std::atomic<bool> silent_{false};
  Subscription subscription_;
};

}  // namespace predictive_stereo
