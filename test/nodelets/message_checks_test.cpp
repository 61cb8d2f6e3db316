#include "nodelets/message_checks.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

namespace predictive_stereo {
namespace {

const ros::Time kLargest(2147483647u, 999999999);

std::string objection(uint32_t sec, uint32_t nsec, ZeroStamp zero = ZeroStamp::kRefused) {
  ros::Time stamp;
  stamp.sec = sec;
  stamp.nsec = nsec;
  return objectionTo(stamp, zero);
}

TEST(MessageChecks, accepted_stamps_can_be_subtracted_and_moved_by_hours) {
  const ros::Time smallest(0, 1);
  for (const ros::Time a : {smallest, ros::Time(1600000000), kLargest}) {
    EXPECT_EQ(objectionTo(a, ZeroStamp::kRefused), "");
    EXPECT_NO_THROW(static_cast<void>(a + ros::Duration(24 * 3600.0)));
    for (const ros::Time b : {ros::Time(), smallest, ros::Time(1600000000), kLargest})
      EXPECT_NO_THROW(static_cast<void>(a - b)) << a << " " << b;
  }
}

TEST(MessageChecks, stamps_that_ros_cannot_compute_with_are_refused_with_value_and_cure) {
  const std::string text = objection(4294967295u, 999999999);
  EXPECT_NE(text.find("stamp 4294967295.999999999 s"), std::string::npos) << text;
  EXPECT_NE(text.find("correct the clock"), std::string::npos) << text;
  for (const uint32_t sec : {2147483648u, 4200000000u}) EXPECT_NE(objection(sec, 0), "") << sec;
  EXPECT_NE(objection(5, 1000000000), "");
  EXPECT_NE(objection(5, 4294967295u), "");
}

TEST(MessageChecks, zero_is_refused_where_it_is_not_legal) {
  EXPECT_NE(objection(0, 0), "");
  EXPECT_NE(objection(0, 0).find("/use_sim_time"), std::string::npos) << "left by a bag's launch";
  EXPECT_EQ(objection(0, 0, ZeroStamp::kLegal), "");
  EXPECT_EQ(objection(0, 1), "");
}

geometry_msgs::TransformStamped transform() {
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = ros::Time(5);
  transform.header.frame_id = "odom";
  transform.child_frame_id = "base";
  transform.transform.rotation.z = transform.transform.rotation.w = std::sqrt(0.5);
  return transform;
}

std::string refusal(const geometry_msgs::TransformStamped& transform) {
  try {
    requireTransform(transform, ZeroStamp::kRefused, "/node");
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(MessageChecks, transforms_that_are_none_are_refused_with_their_names) {
  using Transform = geometry_msgs::TransformStamped;
  EXPECT_EQ(refusal(transform()), "");
  const std::vector<void (*)(Transform&)> faults = {
      [](Transform& t) { t.transform.translation.x = std::numeric_limits<double>::quiet_NaN(); },
      [](Transform& t) { t.transform.translation.y = -std::numeric_limits<double>::infinity(); },
      [](Transform& t) { t.transform.rotation.x = std::numeric_limits<double>::infinity(); },
      [](Transform& t) { t.transform.rotation = geometry_msgs::Quaternion(); },
      [](Transform& t) { t.child_frame_id = "odom"; },
      [](Transform& t) { t.header.stamp = ros::Time(); },
      [](Transform& t) { t.header.stamp = ros::Time(4200000000u, 0); }};
  for (size_t i = 0; i < faults.size(); ++i) {
    Transform bad = transform();
    faults[i](bad);
    const std::string names =
        "transform of '" + bad.child_frame_id + "' in '" + bad.header.frame_id + "' from /node: ";
    EXPECT_EQ(refusal(bad).find(names), 0u) << i << ": " << refusal(bad);
  }
  Transform nameless = transform();
  nameless.child_frame_id.clear();
  EXPECT_NE(refusal(nameless), "");
  nameless = transform();
  nameless.header.frame_id.clear();
  EXPECT_NE(refusal(nameless), "");
}

TEST(MessageChecks, imu_odometry_and_row_alignment) {
  sensor_msgs::Imu imu;
  EXPECT_THROW(requireUsable(imu), std::invalid_argument);
  imu.header.frame_id = "imu";
  EXPECT_NO_THROW(requireUsable(imu));
  imu.angular_velocity.z = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(requireUsable(imu), std::invalid_argument);
  imu.angular_velocity_covariance[0] = -1;  // no gyroscope: its numbers mean nothing
  EXPECT_NO_THROW(requireUsable(imu));

  nav_msgs::Odometry odometry;
  EXPECT_THROW(requireUsable(odometry), std::invalid_argument);
  odometry.child_frame_id = "base";
  EXPECT_NO_THROW(requireUsable(odometry));

  RowAlignment alignment;
  EXPECT_NO_THROW(requireUsable(alignment));
  alignment.column_offset_sigma = std::numeric_limits<double>::infinity();
  EXPECT_THROW(requireUsable(alignment), std::invalid_argument);
}

}  // namespace
}  // namespace predictive_stereo
