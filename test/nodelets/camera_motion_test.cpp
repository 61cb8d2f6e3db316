#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <boost/weak_ptr.hpp>
#include <cmath>
#include <vector>

#include "nodelets/transforms.h"

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
  for (int i = 0; i < 20000; ++i) {
    const auto odometry = odometryAt(1000);
    messages.push_back(odometry);
    history.add(odometry);
  }
  EXPECT_EQ(kept(messages), 10000u);
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

// A path along x: the odometry of each frame, and its pose in tf.
class MotionFromOdometry : public testing::Test {
 protected:
  static constexpr double kFirst_s = 10;

  // @param unseen  whether the motion to this frame was not seen.
  nav_msgs::OdometryPtr add(double stamp_s, double x_m, double twist_mps, bool unseen = false) {
    return add(stamp_s, x_m, x_m, twist_mps, unseen);
  }
  // @param tf_m  where another source has it in tf.
  nav_msgs::OdometryPtr add(double stamp_s, double tf_m, double x_m, double twist_mps,
                            bool unseen) {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "odom";
    transform.header.stamp = ros::Time(stamp_s);
    transform.child_frame_id = "camera";
    transform.transform.translation.x = tf_m;
    transform.transform.rotation.w = 1;
    tf_.setTransform(transform, "test");
    const nav_msgs::OdometryPtr odometry = odometryAt(stamp_s);
    odometry->child_frame_id = "camera";
    odometry->pose.pose.position.x = x_m;
    odometry->pose.pose.orientation.w = 1;
    odometry->pose.covariance =
        covarianceMsg((stamp_s > kFirst_s ? 1e-4 : 0) * Matrix6d::Identity());
    odometry->twist.twist.linear.x = unseen ? 0 : twist_mps;
    odometry->twist.covariance =
        covarianceMsg((unseen ? kUnknownCovariance : 1e-4) * Matrix6d::Identity());
    odometry_.add(odometry);
    return odometry;
  }
  MotionAnswer motion(double previous_s, double now_s) const {
    return cameraMotion(tf_, &odometry_, "camera", ros::Time(previous_s), ros::Time(now_s), "odom");
  }

  tf2::BufferCore tf_;
  OdometryHistory odometry_;
};

TEST_F(MotionFromOdometry, is_known_over_a_lost_frame_that_later_ones_reach_across) {
  add(10.0, 0, 0, true);  // the first frame of the path
  add(10.1, 1, 10);
  add(10.2, 2, 0, true);
  add(10.3, 3.3, 11.5);  // from 10.1
  EXPECT_TRUE(motion(10.0, 10.1).value);
  EXPECT_FALSE(motion(10.1, 10.2).value);
  ASSERT_TRUE(motion(10.1, 10.3).value);
  EXPECT_NEAR(motion(10.1, 10.3).value->T_cam_prev.translation().x(), -2.3, 1e-6);
  EXPECT_FALSE(motion(10.2, 10.3).value) << "it leads from 10.1, not from the lost frame";
}

TEST_F(MotionFromOdometry, from_the_first_frame_is_known_also_if_the_second_one_was_dropped) {
  add(10.0, 0, 0, true);
  add(10.1, 1, 10);
  add(10.2, 2.5, 15);
  EXPECT_TRUE(motion(10.0, 10.2).value);
}

// As after ~reset of EgoMotion: the pose jumps to the origin.
TEST_F(MotionFromOdometry, is_unknown_across_the_beginning_of_another_path) {
  add(10.0, 0, 0, true);
  add(10.1, 1, 10);
  add(10.2, 0, 0, true)->pose.covariance.fill(0);
  add(10.3, 1, 10);
  EXPECT_FALSE(motion(10.1, 10.2).value);
  EXPECT_FALSE(motion(10.1, 10.3).value);
  EXPECT_TRUE(motion(10.2, 10.3).value);
  const PoseAnswer pose =
      cameraPose(tf_, &odometry_, "camera", ros::Time(10.1), ros::Time(10.3), "odom");
  ASSERT_TRUE(pose.value);
  EXPECT_EQ(pose.value->motion_covariance, unseenCovariance());
}

// As of wheels, while EgoMotion runs with publish_tf:=false.
TEST_F(MotionFromOdometry, is_doubted_by_its_difference_from_another_source_in_tf) {
  add(10.0, 0, 0, 0, true);
  add(10.1, 1.1, 1, 10, false);
  add(10.2, 2.2, 2, 0, true);
  add(10.3, 3.2, 3, 10, false);
  ASSERT_TRUE(motion(10.0, 10.1).value);
  Matrix6d expected = 1e-6 * Matrix6d::Identity();
  expected(0, 0) += 0.1 * 0.1;
  EXPECT_TRUE(motion(10.0, 10.1).value->covariance.isApprox(expected, 1e-6));
  ASSERT_TRUE(motion(10.1, 10.2).value) << "the camera is lost, the wheels are not";
  EXPECT_TRUE(motion(10.1, 10.2).value->covariance.isZero());
  EXPECT_TRUE(motion(10.1, 10.3).value);
  EXPECT_TRUE(
      cameraPose(tf_, &odometry_, "camera", ros::Time(10.1), ros::Time(10.2), "odom").value);
}

TEST_F(MotionFromOdometry, is_not_compared_with_poses_that_are_none) {
  for (const double w : {0.0, std::nan("")}) {
    add(10.0, 0, 0, true);
    const nav_msgs::OdometryPtr with_twist_only = add(10.1, 1, 10);
    with_twist_only->pose.pose = geometry_msgs::Pose();
    with_twist_only->pose.pose.orientation.w = w;
    ASSERT_TRUE(motion(10.0, 10.1).value) << w;
    EXPECT_TRUE(motion(10.0, 10.1).value->covariance.isApprox(1e-6 * Matrix6d::Identity())) << w;
  }
}

TEST_F(MotionFromOdometry, says_that_tf_lacks_the_child_frame) {
  add(10.0, 0, 0, true);
  add(10.1, 1, 10);
  EXPECT_EQ(motion(10.0, 10.1).reason, "");
  add(10.2, 2, 10)->child_frame_id = "nowhere";
  const std::string reason =
      "child_frame_id 'nowhere' of odometry has no transform to 'camera' in tf: the covariance of "
      "the motion is unknown";
  ASSERT_TRUE(motion(10.1, 10.2).value);
  EXPECT_TRUE(motion(10.1, 10.2).value->covariance.isZero());
  EXPECT_EQ(motion(10.1, 10.2).reason, reason);
  const PoseAnswer pose =
      cameraPose(tf_, &odometry_, "camera", ros::Time(10.1), ros::Time(10.2), "odom");
  EXPECT_TRUE(pose.value);
  EXPECT_EQ(pose.reason, reason);
}

TEST_F(MotionFromOdometry, since_a_frame_before_the_first_pose_in_tf_will_not_come) {
  add(10.1, 1, 10);
  add(10.2, 2, 10);
  const MotionAnswer answer = motion(10.0, 10.2);
  EXPECT_FALSE(answer.value);
  EXPECT_TRUE(answer.complete);
  EXPECT_EQ(answer.reason, "tf has no pose of the frame before");
  EXPECT_FALSE(motion(10.1, 10.3).complete) << "not yet";
}

TEST_F(MotionFromOdometry, makes_the_pose_as_certain_as_it_was_seen) {
  add(10.0, 0, 0, true);
  add(10.1, 1, 10);
  add(10.2, 1.5, 0, true);
  add(10.3, 2.5, 10);  // from 10.2
  const auto pose = [&](std::optional<double> previous_s, double now_s) {
    return cameraPose(tf_, &odometry_, "camera",
                      previous_s ? std::optional(ros::Time(*previous_s)) : std::nullopt,
                      ros::Time(now_s), "odom");
  };
  EXPECT_TRUE(pose({}, 10.0).value) << "the first frame of the path";
  EXPECT_TRUE(pose(10.3, 10.0).value) << "the first one after stamps went back";
  ASSERT_TRUE(pose(10.0, 10.1).value);
  EXPECT_NEAR(pose(10.0, 10.1).value->T_odom_cam.translation().x(), 1, 1e-6);
  EXPECT_TRUE(pose(10.0, 10.1).value->motion_covariance.isApprox(1e-6 * Matrix6d::Identity()));
  EXPECT_FALSE(pose(10.1, 10.2).value);
  EXPECT_EQ(pose(10.1, 10.2).reason, "the odometry is lost");
  ASSERT_TRUE(pose(10.1, 10.3).value);
  EXPECT_EQ(pose(10.1, 10.3).value->motion_covariance, unseenCovariance());
  const PoseAnswer by_tf_alone =
      cameraPose(tf_, nullptr, "camera", ros::Time(10.0), ros::Time(10.1), "odom");
  ASSERT_TRUE(by_tf_alone.value);
  EXPECT_TRUE(by_tf_alone.value->motion_covariance.isZero());
  EXPECT_FALSE(pose(10.1, 10.4).value) << "not yet in tf";
  EXPECT_FALSE(pose(10.1, 10.4).complete);
}

TEST_F(MotionFromOdometry, is_unknown_if_a_part_of_it_was_not_seen) {
  add(10.0, 0, 0, true);
  add(10.1, 1, 10);
  add(10.2, 1.5, 0, true);
  add(10.3, 2.5, 10);  // from 10.2
  EXPECT_TRUE(motion(10.2, 10.3).value);
  const MotionAnswer answer = motion(10.1, 10.3);
  EXPECT_FALSE(answer.value);
  EXPECT_TRUE(answer.complete);
  EXPECT_EQ(answer.reason, "the odometry is lost");
}

}  // namespace
}  // namespace predictive_stereo
