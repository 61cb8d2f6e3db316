#pragma once

#include <nav_msgs/Odometry.h>
#include <tf2/buffer_core.h>

#include <optional>
#include <string>

#include "nodelets/message_history.h"
#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {

using OdometryHistory = MessageHistory<nav_msgs::Odometry>;

/// A motion or pose of the camera, or the reason why it is unknown.
template <class Value>
struct Answer {
  std::optional<Value> value;
  bool complete = false;  ///< waiting longer does not help
  std::string reason;     ///< why there is no value
};
using MotionAnswer = Answer<CameraMotion>;
using PoseAnswer = Answer<CameraPose>;

/// The motion from tf, and its covariance from odometry of any source.
/// @param odometry  nullptr: no odometry; the covariance is then zero (unknown).
/// @returns no motion, too, if the odometry did not see a part of it: the poses in tf are then
///   partly a guess. It is lost where its twist is unknown (twistIsUnknown).
MotionAnswer cameraMotion(const tf2::BufferCore& tf, const OdometryHistory* odometry,
                          const std::string& camera, ros::Time previous, ros::Time now,
                          const std::string& fixed_frame);

/// The pose from tf, and the covariance of the motion since `previous` as cameraMotion gives it.
/// @param previous  the last frame with a pose; none, or not before `now`: there is none.
/// @returns no pose if the odometry is lost in this frame.
PoseAnswer cameraPose(const tf2::BufferCore& tf, const OdometryHistory* odometry,
                      const std::string& camera, std::optional<ros::Time> previous, ros::Time now,
                      const std::string& fixed_frame);

}  // namespace predictive_stereo
