#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <boost/make_shared.hpp>

#include "nodelets/rotation_input.h"

namespace predictive_stereo {
namespace {

sensor_msgs::ImuConstPtr imu(double stamp_s, const Eigen::Vector3d& rate_radps) {
  auto message = boost::make_shared<sensor_msgs::Imu>();
  message->header.stamp.fromSec(stamp_s);
  message->header.frame_id = "imu";
  message->angular_velocity.x = rate_radps.x();
  message->angular_velocity.y = rate_radps.y();
  message->angular_velocity.z = rate_radps.z();
  return message;
}

double angleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(a.transpose() * b).angle();
}

TEST(ImuRotation, integrates_between_stamps_that_are_not_its_own) {
  ImuRotation::History history;
  ImuRotation rotation{history};
  // A rotation about one axis with growing angular velocity.
  for (int i = 0; i <= 100; ++i) history.add(imu(10 + 0.01 * i, {0, 0, 0.02 * i}));
  const auto answer = rotation.between(ros::Time(10.205), ros::Time(10.503));
  ASSERT_TRUE(answer.value) << answer.reason;
  // The integral of 2 t from 0.205 s to 0.503 s is the rotation of now relative to previous.
  const double angle_rad = 0.503 * 0.503 - 0.205 * 0.205;
  const Eigen::Matrix3d R_previous_now =
      Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_LT(angleBetween(*answer.value, R_previous_now.transpose()), 1e-6);
  EXPECT_EQ(rotation.frame(), "imu");
}

TEST(ImuRotation, two_messages_out_of_order_are_put_in_order) {
  ImuRotation::History history;
  const ImuRotation rotation{history};
  for (int i = 0; i <= 100; ++i) {
    const int swapped = i == 55 || i == 56 ? 111 - i : i;
    history.add(imu(10 + 0.01 * swapped, {0, 0, 0.02 * swapped}));
  }
  const auto answer = rotation.between(ros::Time(10.2), ros::Time(10.8));
  ASSERT_TRUE(answer.value) << answer.reason;
  EXPECT_NEAR(Eigen::AngleAxisd(*answer.value).angle(), 0.8 * 0.8 - 0.2 * 0.2, 1e-6);
}

TEST(ImuRotation, follows_an_axis_that_turns_with_the_body) {
  ImuRotation::History history;
  ImuRotation rotation{history};
  for (int i = 0; i <= 50; ++i) history.add(imu(10 + 0.02 * i, {1, 0, 0}));
  for (int i = 51; i <= 100; ++i) history.add(imu(10 + 0.02 * i, {0, 1, 0}));
  const auto answer = rotation.between(ros::Time(10), ros::Time(12));
  ASSERT_TRUE(answer.value);
  const Eigen::Matrix3d R_previous_now = (Eigen::AngleAxisd(1.01, Eigen::Vector3d::UnitX()) *
                                          Eigen::AngleAxisd(0.99, Eigen::Vector3d::UnitY()))
                                             .toRotationMatrix();
  EXPECT_LT(angleBetween(*answer.value, R_previous_now.transpose()), 0.02);
}

TEST(ImuRotation, what_it_shows_at_rest_is_its_bias) {
  const Eigen::Vector3d bias(0.01, -0.02, 0.005);
  ImuRotation::History history;
  ImuRotation rotation{history};
  for (int i = 0; i <= 100; ++i) history.add(imu(10 + 0.01 * i, bias));
  EXPECT_GT(angleBetween(*rotation.between(ros::Time(10), ros::Time(11)).value,
                         Eigen::Matrix3d::Identity()),
            0.02);
  rotation.learnBias(ros::Time(10), ros::Time(11));
  EXPECT_LT((rotation.bias_radps() - bias).norm(), 1e-9);
  EXPECT_LT(angleBetween(*rotation.between(ros::Time(10), ros::Time(11)).value,
                         Eigen::Matrix3d::Identity()),
            1e-6);
}

TEST(ImuRotation, says_what_is_missing) {
  ImuRotation::History history;
  ImuRotation rotation{history};
  EXPECT_FALSE(rotation.between(ros::Time(10), ros::Time(10.1)).value);
  for (int i = 0; i < 100; ++i) history.add(imu(10 + 0.01 * i, {0, 0, 0}));
  const auto late = rotation.between(ros::Time(10.5), ros::Time(11.5));
  EXPECT_FALSE(late.value);
  EXPECT_FALSE(late.complete) << "it may still come";
  const auto early = rotation.between(ros::Time(9.9), ros::Time(10.5));
  EXPECT_FALSE(early.value);
  EXPECT_TRUE(early.complete);
  EXPECT_NE(early.reason.find("begin after the previous image's"), std::string::npos);

  // After a gap, or after stamps that go far back, earlier measurements cannot be used.
  history.add(imu(11.5, {0, 0, 0}));
  const auto gap = rotation.between(ros::Time(10.9), ros::Time(11.2));
  EXPECT_FALSE(gap.value);
  EXPECT_NE(gap.reason.find("jump by 0.51 s"), std::string::npos) << gap.reason;
  history.add(imu(10.9, {0, 0, 0}));
  EXPECT_FALSE(rotation.between(ros::Time(10.5), ros::Time(10.9)).value);
}

TEST(ImuRotation, takes_a_measurement_once) {
  ImuRotation::History history;
  ImuRotation rotation{history};
  for (int i = 0; i <= 10; ++i)
    for (int copy = 0; copy < 2; ++copy) history.add(imu(10 + 0.01 * i, {0, 0, 1}));
  const auto answer = rotation.between(ros::Time(10), ros::Time(10.1));
  ASSERT_TRUE(answer.value) << answer.reason;
  EXPECT_NEAR(Eigen::AngleAxisd(*answer.value).angle(), 0.1, 1e-6);
}

TEST(ImuRotation, an_imu_may_have_no_gyroscope) {
  ImuRotation::History history;
  ImuRotation rotation{history};
  for (int i = 0; i <= 10; ++i) {
    auto message = boost::make_shared<sensor_msgs::Imu>(*imu(10 + 0.01 * i, {0, 0, 0}));
    message->angular_velocity_covariance[0] = -1;
    history.add(message);
  }
  const auto answer = rotation.between(ros::Time(10), ros::Time(10.1));
  EXPECT_FALSE(answer.value);
  EXPECT_NE(answer.reason.find("no angular velocity"), std::string::npos) << answer.reason;
}

}  // namespace
}  // namespace predictive_stereo
