#include "nodelets/motion_source.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <boost/weak_ptr.hpp>
#include <vector>

namespace predictive_stereo {
namespace {

nav_msgs::OdometryPtr odometryAt(double stamp_s) {
  auto odometry = boost::make_shared<nav_msgs::Odometry>();
  odometry->header.stamp = ros::Time(stamp_s);
  return odometry;
}

// Number of messages in the history, which is their only owner.
size_t kept(const std::vector<boost::weak_ptr<nav_msgs::Odometry>>& messages) {
  size_t count = 0;
  for (const auto& message : messages) count += !message.expired();
  return count;
}

TEST(OdometryHistory, gives_the_first_that_is_not_older) {
  OdometryHistory history;
  EXPECT_EQ(history.at(ros::Time(10)), nullptr);
  for (const double stamp_s : {10.0, 10.1, 10.2}) history.add(odometryAt(stamp_s));
  EXPECT_EQ(history.at(ros::Time(10.05))->header.stamp, ros::Time(10.1));
  EXPECT_EQ(history.at(ros::Time(10.2))->header.stamp, ros::Time(10.2));
  EXPECT_EQ(history.at(ros::Time(10.3)), nullptr);
}

TEST(OdometryHistory, gives_the_last_that_is_older) {
  OdometryHistory history;
  EXPECT_EQ(history.before(ros::Time(10)), nullptr);
  for (const double stamp_s : {10.0, 10.1, 10.2}) history.add(odometryAt(stamp_s));
  EXPECT_EQ(history.before(ros::Time(10)), nullptr);
  EXPECT_EQ(history.before(ros::Time(10.1))->header.stamp, ros::Time(10.0));
  EXPECT_EQ(history.before(ros::Time(11))->header.stamp, ros::Time(10.2));
}

TEST(OdometryHistory, keeps_three_seconds_whatever_the_rate) {
  for (const int rate_hz : {10, 200}) {
    OdometryHistory history;
    std::vector<boost::weak_ptr<nav_msgs::Odometry>> messages;
    for (int i = 0; i < 100 * rate_hz; ++i) {
      const auto odometry = odometryAt(1000 + static_cast<double>(i) / rate_hz);
      messages.push_back(odometry);
      history.add(odometry);
    }
    EXPECT_NEAR(static_cast<double>(kept(messages)), 3 * rate_hz, 2);
    EXPECT_FALSE(messages.back().expired());
  }
}

TEST(OdometryHistory, keeps_a_bounded_number_of_equal_stamps) {
  OdometryHistory history;
  std::vector<boost::weak_ptr<nav_msgs::Odometry>> messages;
  for (int i = 0; i < 5000; ++i) {
    const auto odometry = odometryAt(1000);
    messages.push_back(odometry);
    history.add(odometry);
  }
  EXPECT_EQ(kept(messages), 2000u);
}

TEST(OdometryHistory, forgets_a_later_pass) {
  OdometryHistory history;
  history.add(odometryAt(50));
  history.goBackTo(ros::Time(49.8));
  EXPECT_NE(history.at(ros::Time(50)), nullptr) << "a little back is no other pass";
  history.goBackTo(ros::Time(10));
  EXPECT_EQ(history.at(ros::Time(10)), nullptr);
  history.add(odometryAt(20));
  history.add(odometryAt(10));
  EXPECT_EQ(history.at(ros::Time(15)), nullptr) << "of the pass before";
}

}  // namespace
}  // namespace predictive_stereo
