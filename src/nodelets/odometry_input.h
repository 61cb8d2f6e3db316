#pragma once

#include <nav_msgs/Odometry.h>
#include <predictive_stereo/RowAlignment.h>
#include <ros/node_handle.h>
#include <std_msgs/Header.h>

#include <optional>
#include <string>

#include "nodelets/message_input.h"
#include "nodelets/nodelet_params.h"
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
  /// @param params  must outlive this object. @param columns_topic  of the column offset.
  OdometryInput(const ros::NodeHandle& node, Health& health, Arrivals& arrivals, const TfInput& tf,
                const FrameNodeletParams& params, const std::string& columns_topic)
      : health_(health),
        arrivals_(arrivals),
        tf_(tf),
        params_(params),
        columns_topic_(columns_topic),
        topic_(node.resolveName("odometry")),
        is_chosen_(topic_ != node.resolveName("odometry", false)),
        odometry_(node, health, arrivals),
        columns_(node, health, arrivals) {}

  void start() {
    odometry_.listenTo("odometry");
    columns_.listenTo(columns_topic_);
  }
  /// After this has returned, nothing is received.
  void stop() {
    odometry_.listenTo("");
    columns_.listenTo("");
  }

  void goBackTo(ros::Time stamp) {
    odometry_.history().goBackTo(stamp);
    columns_.history().goBackTo(stamp);
  }

  /// Motion since the frame of `previous`, see cameraMotion; none: unknown.
  std::optional<CameraMotion> motion(ros::Time previous, const std_msgs::Header& now) {
    const auto ask = [&](const OdometryHistory* odometry) {
      return cameraMotion(tf_.buffer, odometry, now.frame_id, previous, now.stamp,
                          params_.odom_frame);
    };
    return waitFor<CameraMotion>(now, ask, "motion", ": matched without prediction");
  }

  /// See cameraPose; none: unknown.
  std::optional<CameraPose> pose(std::optional<ros::Time> previous, const std_msgs::Header& now) {
    const auto ask = [&](const OdometryHistory* odometry) {
      return cameraPose(tf_.buffer, odometry, now.frame_id, previous, now.stamp,
                        params_.odom_frame);
    };
    return waitFor<CameraPose>(now, ask, "pose", ": no moving objects are found");
  }

  const MessageHistory<RowAlignment>& columns() const { return columns_.history(); }

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
    const double timeout_s = isAbsent(now.frame_id) ? 0 : params_.transform_timeout;
    const bool complete = arrivals_.waitFor(timeout_s, [&] {
      answer = ask(odometry_.isExpected() ? &odometry_.history() : nullptr);
      return answer.complete;
    });
    if (answer.value && !complete) odometry_.expectNone();
    in_vain_.reset();
    if (!answer.value && !complete) in_vain_ = now.stamp;
    health_.problem(what, answer.value ? ""
                          : complete   ? answer.reason + effect
                                       : notInTf(now, what, effect));
    health_.problem("odometry", is_chosen_ && !odometry_.isPublished()
                                    ? "nobody publishes nav_msgs/Odometry on " + topic_ +
                                          " (launch argument odometry:=<topic>): the covariance "
                                          "of the motion is unknown"
                                : answer.value ? answer.reason
                                               : "");
    return answer.value;
  }

  // The text is not that of tf, which contains stamps: a text that changes is logged every time.
  std::string notInTf(const std_msgs::Header& now, const std::string& what,
                      const std::string& effect) const {
    if (now.frame_id.empty()) return kNoFrame + effect;
    return "tf has no " + what + " of '" + now.frame_id + "' relative to odom_frame '" +
           params_.odom_frame + "' at the image's stamp within transform_timeout = " +
           cv::format("%g s", params_.transform_timeout) + effect + ". " +
           (isLate(tf_.buffer, params_.odom_frame, now.frame_id, now.stamp)
                ? kLateInTf
                : "Run the EgoMotion nodelet with publish_tf, or set odom_frame to the fixed "
                  "frame of your odometry");
  }

  // Then nobody publishes the motion, or it is later than the timeout.
  bool isAbsent(const std::string& camera) const {
    std::string error;
    return in_vain_ && !lookUpTransform(tf_.buffer, params_.odom_frame, camera, *in_vain_, error);
  }

  Health& health_;
  Arrivals& arrivals_;
  const TfInput& tf_;
  const FrameNodeletParams& params_;
  const std::string columns_topic_;
  const std::string topic_;  // of odometry
  const bool is_chosen_;     // by a remapping; otherwise there may be none
  MessageInput<nav_msgs::Odometry> odometry_;
  MessageInput<RowAlignment> columns_;
  std::optional<ros::Time> in_vain_;  // the last frame that tf was waited for, without an answer
};

}  // namespace predictive_stereo
