#pragma once

#include <nav_msgs/Odometry.h>
#include <tf2/buffer_core.h>

#include <optional>
#include <string>

#include "nodelets/message_history.h"
#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {

using OdometryHistory = MessageHistory<nav_msgs::Odometry>;

/// The camera's motion between two frames, or why there is none.
struct MotionAnswer {
  std::optional<CameraMotion> motion;
  bool complete = false;  ///< nothing is left to wait for
  std::string reason;     ///< where there is no motion
};

/// The motion from tf, its covariance from the odometry, be it our own or anybody's.
/// @param odometry  null: there is none; the covariance is then zero (unknown).
/// @returns no motion also where the odometry says that it was lost at either frame: tf then holds
///   a pose that means nothing.
MotionAnswer cameraMotion(const tf2::BufferCore& tf, const OdometryHistory* odometry,
                          const std::string& camera, ros::Time previous, ros::Time now,
                          const std::string& fixed_frame);

}  // namespace predictive_stereo
