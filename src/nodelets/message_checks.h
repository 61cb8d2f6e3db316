/// What a message from another node must have; without it the message is refused.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/RowAlignment.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>

#include <string>

namespace predictive_stereo {

/// Whether 0 is a legal stamp: that of a calibration or transform that holds at all times.
enum class ZeroStamp { kRefused, kLegal };

/// Why a stamp is refused, and the cure; empty: it is not. ros::Time throws for sums and
/// differences beyond 32 bits: no two stamps that are accepted do so, nor one with an hour added to
/// it.
std::string objectionTo(ros::Time stamp, ZeroStamp zero);

/// @throws std::invalid_argument with the objection.
void requireStamp(ros::Time stamp, ZeroStamp zero);

/// Stamp, names of both frames, finite numbers, and a unit quaternion.
/// @throws std::invalid_argument that names the frames and `publisher`.
void requireTransform(const geometry_msgs::TransformStamped& transform, ZeroStamp zero,
                      const std::string& publisher);

/// Frame, and a finite angular velocity, unless the message says that it has none.
/// @throws std::invalid_argument
void requireImu(const sensor_msgs::Imu& imu);

/// The child frame, to which twist and covariance belong.
/// @throws std::invalid_argument
void requireOdometry(const nav_msgs::Odometry& odometry);

/// A finite column offset.
/// @throws std::invalid_argument
void requireRowAlignment(const RowAlignment& alignment);

}  // namespace predictive_stereo
