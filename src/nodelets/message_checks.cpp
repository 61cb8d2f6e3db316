#include "nodelets/message_checks.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <stdexcept>

namespace predictive_stereo {
namespace {

constexpr uint32_t kFirstRefused_s = 1u << 31, kSecond_ns = 1000000000;

bool allFinite(const geometry_msgs::Transform& transform) {
  const auto& t = transform.translation;
  const auto& q = transform.rotation;
  return std::isfinite(t.x + t.y + t.z) && std::isfinite(q.x + q.y + q.z + q.w);
}

// With the tolerance of tf2.
bool isRotation(const geometry_msgs::Quaternion& q) {
  return std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) <= 1e-2;
}

std::string objectionTo(const geometry_msgs::TransformStamped& transform, ZeroStamp zero) {
  if (transform.header.frame_id.empty() || transform.child_frame_id.empty())
    return "both frames need a name: correct its publisher";
  if (transform.header.frame_id == transform.child_frame_id)
    return "a frame cannot be its own parent: correct its publisher";
  if (!allFinite(transform.transform)) return "is not finite: correct its publisher";
  if (!isRotation(transform.transform.rotation))
    return "the rotation is no unit quaternion: correct its publisher";
  return objectionTo(transform.header.stamp, zero);
}

}  // namespace

std::string objectionTo(ros::Time stamp, ZeroStamp zero) {
  if (stamp.isZero())
    return zero == ZeroStamp::kLegal ? "" : "stamp 0: its publisher must set header.stamp";
  if (stamp.sec < kFirstRefused_s && stamp.nsec < kSecond_ns) return "";
  char text[200];
  std::snprintf(text, sizeof text,
                "stamp %u.%09u s: ros::Time computes with less than 2147483648 s (year 2038) and "
                "less than 1000000000 ns; correct the clock of its publisher",
                stamp.sec, stamp.nsec);
  return text;
}

void requireStamp(ros::Time stamp, ZeroStamp zero) {
  const std::string objection = objectionTo(stamp, zero);
  if (!objection.empty()) throw std::invalid_argument(objection);
}

void requireTransform(const geometry_msgs::TransformStamped& transform, ZeroStamp zero,
                      const std::string& publisher) {
  const std::string objection = objectionTo(transform, zero);
  if (!objection.empty())
    throw std::invalid_argument("transform of '" + transform.child_frame_id + "' in '" +
                                transform.header.frame_id + "' from " + publisher + ": " +
                                objection);
}

void requireImu(const sensor_msgs::Imu& imu) {
  if (imu.header.frame_id.empty())
    throw std::invalid_argument("frame_id is empty: set it in the IMU's driver");
  const auto& w = imu.angular_velocity;
  // In sensor_msgs/Imu, -1 means that the device does not measure angular velocity.
  if (imu.angular_velocity_covariance[0] != -1 && !std::isfinite(w.x + w.y + w.z))
    throw std::invalid_argument("angular_velocity is not finite: correct the IMU's driver");
}

void requireOdometry(const nav_msgs::Odometry& odometry) {
  if (odometry.child_frame_id.empty())
    throw std::invalid_argument("child_frame_id is empty: set it in the node of the odometry");
}

void requireRowAlignment(const RowAlignment& alignment) {
  if (!std::isfinite(alignment.column_offset + alignment.column_offset_sigma +
                     alignment.column_correction))
    throw std::invalid_argument("its column offset is not finite: correct its publisher");
}

}  // namespace predictive_stereo
