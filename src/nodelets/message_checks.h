/// What a message from another node must have; without it the message is refused.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/RowAlignment.h>
#include <ros/time.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

namespace predictive_stereo {

/// Whether 0 is a legal stamp: that of a calibration or transform that holds at all times.
enum class ZeroStamp { kRefused, kLegal };

/// Why a stamp is refused, and the cure; empty: it is not. ros::Time throws for sums and
/// differences beyond 32 bits: no two stamps that are accepted do so, nor one with an hour added to
/// it.
inline std::string objectionTo(ros::Time stamp, ZeroStamp zero) {
  if (stamp.isZero())
    return zero == ZeroStamp::kLegal ? ""
                                     : "stamp 0: its publisher must set header.stamp (or is "
                                       "/use_sim_time true, and no clock runs?)";
  if (stamp.sec < 1u << 31 && stamp.nsec < 1000000000) return "";
  return cv::format(
      "stamp %u.%09u s: ros::Time computes with less than 2147483648 s (year 2038) and less than "
      "1000000000 ns; correct the clock of its publisher",
      stamp.sec, stamp.nsec);
}

/// @throws std::invalid_argument with the objection.
inline void requireStamp(ros::Time stamp, ZeroStamp zero) {
  const std::string objection = objectionTo(stamp, zero);
  if (!objection.empty()) throw std::invalid_argument(objection);
}

/// Names of both frames, finite numbers, a unit quaternion, and a stamp.
inline std::string objectionTo(const geometry_msgs::TransformStamped& transform, ZeroStamp zero) {
  const auto& t = transform.transform.translation;
  const auto& q = transform.transform.rotation;
  if (transform.header.frame_id.empty() || transform.child_frame_id.empty())
    return "both frames need a name: correct its publisher";
  if (transform.header.frame_id == transform.child_frame_id)
    return "a frame cannot be its own parent: correct its publisher";
  if (!std::isfinite(t.x + t.y + t.z) || !std::isfinite(q.x + q.y + q.z + q.w))
    return "is not finite: correct its publisher";
  constexpr double kTolerance = 1e-2;  // as in tf2
  if (!(std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) <= kTolerance))
    return "the rotation is no unit quaternion: correct its publisher";
  return objectionTo(transform.header.stamp, zero);
}

/// @throws std::invalid_argument with the objection, which names the frames and `publisher`.
inline void requireTransform(const geometry_msgs::TransformStamped& transform, ZeroStamp zero,
                             const std::string& publisher) {
  const std::string objection = objectionTo(transform, zero);
  if (!objection.empty())
    throw std::invalid_argument("transform of '" + transform.child_frame_id + "' in '" +
                                transform.header.frame_id + "' from " + publisher + ": " +
                                objection);
}

/// Frame, and a finite angular velocity, unless the message says that it has none.
/// @throws std::invalid_argument
inline void requireUsable(const sensor_msgs::Imu& imu) {
  if (imu.header.frame_id.empty())
    throw std::invalid_argument("frame_id is empty: set it in the IMU's driver");
  const auto& w = imu.angular_velocity;
  // In sensor_msgs/Imu, -1 means that the device does not measure angular velocity.
  if (imu.angular_velocity_covariance[0] != -1 && !std::isfinite(w.x + w.y + w.z))
    throw std::invalid_argument("angular_velocity is not finite: correct the IMU's driver");
}

/// The child frame, to which twist and covariance belong.
/// @throws std::invalid_argument
inline void requireUsable(const nav_msgs::Odometry& odometry) {
  if (odometry.child_frame_id.empty())
    throw std::invalid_argument("child_frame_id is empty: set it in the node of the odometry");
}

/// A finite column offset.
/// @throws std::invalid_argument
inline void requireUsable(const RowAlignment& alignment) {
  if (!std::isfinite(alignment.column_offset + alignment.column_offset_sigma +
                     alignment.column_correction))
    throw std::invalid_argument("its column offset is not finite: correct its publisher");
}

/// A mask of moving objects is compared with an image, see movedMask.
inline void requireUsable(const sensor_msgs::Image&) {}

}  // namespace predictive_stereo
