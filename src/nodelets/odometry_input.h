#pragma once

#include <nav_msgs/Odometry.h>
#include <predictive_stereo/RowAlignment.h>
#include <ros/node_handle.h>
#include <std_msgs/Header.h>

#include <atomic>
#include <optional>
#include <sstream>
#include <string>

#include "nodelets/callbacks.h"
#include "nodelets/message_checks.h"
#include "nodelets/stereo_messages.h"
#include "nodelets/tf_input.h"
#include "nodelets/threads.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {

/// The camera's motion and pose from tf, with the covariance from odometry. It waits for both, and
/// reports what is missing. Also the offset of the right image's columns, see RowAlignment: it does
/// not wait for this.
class OdometryInput {
 public:
  /// @param fixed_frame  the parameter odom_frame. @param timeout_s  transform_timeout.
  /// @param columns_topic  of the column offset.
  OdometryInput(const ros::NodeHandle& node, Health& health, Arrivals& arrivals, const TfInput& tf,
                const std::string& fixed_frame, double timeout_s, const std::string& columns_topic)
      : node_(node),
        health_(health),
        arrivals_(arrivals),
        tf_(tf),
        fixed_frame_(fixed_frame),
        timeout_s_(timeout_s),
        columns_topic_(columns_topic) {}

  void start() {
    odometry_subscription_.replace(
        subscribe<nav_msgs::Odometry>(node_, health_, "odometry", kRoscppQueue,
                                      [this](const nav_msgs::OdometryConstPtr& odometry) {
                                        requireOdometry(*odometry);
                                        odometry_.add(odometry);
                                        silent_ = false;
                                        arrivals_.notify();
                                      }));
    columns_subscription_.replace(subscribe<RowAlignment>(
        node_, health_, columns_topic_, kRoscppQueue, [this](const RowAlignmentConstPtr& columns) {
          requireRowAlignment(*columns);
          columns_.add(columns);
        }));
  }

  /// After this has returned, nothing is received.
  void stop() {
    odometry_subscription_.shutdown();
    columns_subscription_.shutdown();
    odometry_.clear();
    columns_.clear();
    silent_ = false;
  }

  void goBackTo(ros::Time stamp) {
    odometry_.goBackTo(stamp);
    columns_.goBackTo(stamp);
  }

  /// Motion since the frame of `previous`, see cameraMotion; none: unknown.
  std::optional<CameraMotion> motion(ros::Time previous, const std_msgs::Header& now) {
    const auto ask = [&](const OdometryHistory* odometry) {
      return cameraMotion(tf_.buffer, odometry, now.frame_id, previous, now.stamp, fixed_frame_);
    };
    return waitFor<CameraMotion>(now, ask, "motion", ": matched without prediction");
  }

  /// See cameraPose; none: unknown.
  std::optional<CameraPose> pose(std::optional<ros::Time> previous, const std_msgs::Header& now) {
    const auto ask = [&](const OdometryHistory* odometry) {
      return cameraPose(tf_.buffer, odometry, now.frame_id, previous, now.stamp, fixed_frame_);
    };
    return waitFor<CameraPose>(now, ask, "pose", ": no velocities");
  }

  const MessageHistory<RowAlignment>& columns() const { return columns_; }

 private:
  /// Calls `ask` after each arrival until its answer is complete or the time is over. After a
  /// timeout with a usable answer, it does not wait again until odometry has arrived; after one
  /// without an answer, not while tf still has no pose for the frame that was waited for.
  /// @param ask  gives an Answer from an OdometryHistory; from nullptr if there is nothing to wait
  ///   for.
  /// @param what, effect  for the report if there is no value.
  template <class Value, class Ask>
  std::optional<Value> waitFor(const std_msgs::Header& now, const Ask& ask, const std::string& what,
                               const std::string& effect) {
    Answer<Value> answer;
    const double timeout_s = isAbsent(now.frame_id) ? 0 : timeout_s_;
    const bool complete = arrivals_.waitFor(timeout_s, [&] {
      const bool listen = odometry_subscription_.isPublished() && !silent_;
      answer = ask(listen ? &odometry_ : nullptr);
      return answer.complete;
    });
    if (answer.value && !complete) silent_ = true;
    in_vain_.reset();
    if (!answer.value && !complete) in_vain_ = now.stamp;
    if (answer.value)
      health_.solved(what);
    else
      health_.problem(what, complete ? answer.reason + effect : notInTf(now, what, effect));
    return answer.value;
  }

  // The text is not that of tf, which contains stamps: a text that changes is logged every time.
  std::string notInTf(const std_msgs::Header& now, const std::string& what,
                      const std::string& effect) const {
    if (now.frame_id.empty()) return kNoFrame + effect;
    std::ostringstream text;
    text << "tf has no " << what << " of '" << now.frame_id << "' relative to odom_frame '"
         << fixed_frame_ << "' at the image's stamp within transform_timeout = " << timeout_s_
         << " s" << effect << ". "
         << "Run the EgoMotion nodelet with publish_tf, or set odom_frame to the fixed frame of "
            "your odometry";
    return text.str();
  }

  // Then the motion is not late: nobody publishes it.
  bool isAbsent(const std::string& camera) const {
    std::string error;
    return in_vain_ && !lookUpTransform(tf_.buffer, fixed_frame_, camera, *in_vain_, error);
  }

  ros::NodeHandle node_;
  Health& health_;
  Arrivals& arrivals_;
  const TfInput& tf_;
  const std::string fixed_frame_;
  const double timeout_s_;
  const std::string columns_topic_;
  OdometryHistory odometry_;
  MessageHistory<RowAlignment> columns_;
  std::atomic<bool> silent_{false};
  std::optional<ros::Time> in_vain_;  // the last frame that tf was waited for, without an answer
  Subscription odometry_subscription_, columns_subscription_;
};

}  // namespace predictive_stereo
