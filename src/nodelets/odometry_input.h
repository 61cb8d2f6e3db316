#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>
#include <std_msgs/Header.h>

#include <atomic>
#include <optional>
#include <string>

#include "nodelets/arrivals.h"
#include "nodelets/callbacks.h"
#include "nodelets/motion_source.h"
#include "nodelets/tf_input.h"

namespace predictive_stereo {

/// The camera's motion and pose from tf, with the covariance from odometry. It waits for both, and
/// reports what is missing.
class OdometryInput {
 public:
  /// @param fixed_frame  the parameter odom_frame. @param timeout_s  transform_timeout.
  OdometryInput(const ros::NodeHandle& node, Health& health, Arrivals& arrivals, const TfInput& tf,
                const std::string& fixed_frame, double timeout_s)
      : node_(node),
        health_(health),
        arrivals_(arrivals),
        tf_(tf),
        fixed_frame_(fixed_frame),
        timeout_s_(timeout_s) {}

  void start();
  /// After this has returned, nothing is received.
  void stop();
  void goBackTo(ros::Time stamp) { history_.goBackTo(stamp); }

  /// Motion since the frame of `previous`, see cameraMotion; none: unknown.
  std::optional<CameraMotion> motion(ros::Time previous, const std_msgs::Header& now);
  /// See cameraPose; none: unknown.
  std::optional<CameraPose> pose(std::optional<ros::Time> previous, const std_msgs::Header& now);

 private:
  /// Calls `ask` after each arrival until its answer is complete or the time is over. After a
  /// timeout with a usable answer, it does not wait again until odometry has arrived; after one
  /// without an answer, not while tf still has no pose for the frame that was waited for.
  /// @param ask  gives a MotionAnswer or PoseAnswer from an OdometryHistory; from nullptr if there
  ///   is nothing to wait for.
  template <class Ask>
  auto waitFor(const std_msgs::Header& now, const Ask& ask);
  bool isAbsent(const std::string& camera) const;

  ros::NodeHandle node_;
  Health& health_;
  Arrivals& arrivals_;
  const TfInput& tf_;
  const std::string fixed_frame_;
  const double timeout_s_;
  OdometryHistory history_;
  std::atomic<bool> silent_{false};
  std::optional<ros::Time> in_vain_;  // the last frame that tf was waited for, without an answer
  Subscription subscription_;
};

}  // namespace predictive_stereo
