/// Odometry in situations that occur with cameras on robots.
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <rosgraph_msgs/Log.h>
#include <sensor_msgs/Imu.h>
#include <std_srvs/Empty.h>
#include <tf2_msgs/TFMessage.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "nodelet_fixture.h"

namespace predictive_stereo {
namespace {

constexpr double kUnknownVariance = 9999;

Eigen::Vector3d position(const nav_msgs::Odometry& odometry) {
  const auto& p = odometry.pose.pose.position;
  return {p.x, p.y, p.z};
}

class EgoMotionScenarios : public NodeletTest {
 protected:
  EgoMotionScenarios() : extrinsic_(street().extrinsic()) {}

  void start() {
    load("EgoMotion");
    odometry_ = std::make_unique<Recorder<nav_msgs::Odometry>>(node_, "odometry");
    pose_ = std::make_unique<Recorder<geometry_msgs::PoseWithCovarianceStamped>>(node_,
                                                                                 "odometry/pose");
    ASSERT_TRUE(player_.waitForSubscribers());
    ASSERT_TRUE(eventually([&] { return odometry_->connected() && pose_->connected(); }));
  }
  /// Publishes the pair and returns its odometry; nullptr: none arrived.
  nav_msgs::OdometryConstPtr odometryOf(const StereoPair& pair) {
    player_.publish(pair);
    eventually([&] { return odometry_->at(pair.left->header.stamp) != nullptr; }, 20);
    return odometry_->at(pair.left->header.stamp);
  }
  nav_msgs::OdometryConstPtr odometryOf(int index) { return odometryOf(street().pair(index)); }

  /// True pose of base_link at `to` in base_link at `from`.
  static Eigen::Isometry3d truth(int from, int to) {
    return street().T_world_base(from).inverse() * street().T_world_base(to);
  }

  StaticTransform extrinsic_;
  std::unique_ptr<Recorder<nav_msgs::Odometry>> odometry_;
  std::unique_ptr<Recorder<geometry_msgs::PoseWithCovarianceStamped>> pose_;
};

bool allFinite(const nav_msgs::Odometry& odometry) {
  const auto finite = [](double value) { return std::isfinite(value); };
  const auto& q = odometry.pose.pose.orientation;
  const auto &v = odometry.twist.twist.linear, &w = odometry.twist.twist.angular;
  return position(odometry).allFinite() && finite(q.x + q.y + q.z + q.w) &&
         finite(v.x + v.y + v.z + w.x + w.y + w.z) &&
         std::all_of(odometry.pose.covariance.begin(), odometry.pose.covariance.end(), finite) &&
         std::all_of(odometry.twist.covariance.begin(), odometry.twist.covariance.end(), finite);
}

// A hand covers both lenses.
StereoPair covered(const StereoPair& pair, uint8_t brightness = 30) {
  const auto grey = [&](const sensor_msgs::ImageConstPtr& image) {
    auto copy = boost::make_shared<sensor_msgs::Image>(*image);
    std::fill(copy->data.begin(), copy->data.end(), brightness);
    return copy;
  };
  return {grey(pair.left), grey(pair.right), pair.left_info, pair.right_info};
}

TEST_F(EgoMotionScenarios, a_covered_camera_goes_on_and_is_found_again) {
  start();
  for (int i : {0, 1}) ASSERT_TRUE(odometryOf(i));
  const nav_msgs::OdometryConstPtr before = odometryOf(2);
  ASSERT_TRUE(before);
  EXPECT_LT(before->pose.covariance[0], 1);

  const nav_msgs::OdometryConstPtr lost = odometryOf(covered(street().pair(3)));
  ASSERT_TRUE(lost);
  const double error_m = (position(*lost) - truth(0, 3).translation()).norm();
  EXPECT_LT(error_m, 0.3 * (position(*before) - truth(0, 3).translation()).norm());
  EXPECT_LT(error_m, 3 * std::sqrt(lost->pose.covariance[0]));
  EXPECT_LT(lost->pose.covariance[0], 1);
  EXPECT_GT(lost->pose.covariance[0], 2 * before->pose.covariance[0]);
  for (int i = 0; i < 36; i += 7) EXPECT_EQ(lost->twist.covariance[i], kUnknownVariance);
  EXPECT_TRUE(eventually([&] { return pose_->at(lost->header.stamp) != nullptr; }));
  EXPECT_EQ(pose_->last()->pose.covariance[0], lost->pose.covariance[0]);
  EXPECT_TRUE(says("EgoMotion",
                   "lost: too few features agree on a motion. Are the images dark, blurred, "
                   "without texture, or not rectified, or the lenses covered?"));
  EXPECT_TRUE(eventually([&] { return value("EgoMotion", "pose") == "held"; }));

  // The next good frame is compared with the frame before the loss, so no motion is missing.
  const nav_msgs::OdometryConstPtr after = odometryOf(4);
  ASSERT_TRUE(after);
  EXPECT_LT(after->pose.covariance[0], lost->pose.covariance[0]);
  EXPECT_LT((position(*after) - truth(0, 4).translation()).norm(), 0.05);
  EXPECT_TRUE(eventually([&] { return value("EgoMotion", "inliers") != "0"; }));
  EXPECT_TRUE(eventually([&] { return value("EgoMotion", "pose") == "known"; }));
}

StereoPair later(StereoPair pair, double seconds) {
  const auto shift = [&](auto& message) {
    auto copy = boost::make_shared<std::decay_t<decltype(*message)>>(*message);
    copy->header.stamp += ros::Duration(seconds);
    message = copy;
  };
  shift(pair.left);
  shift(pair.right);
  shift(pair.left_info);
  shift(pair.right_info);
  return pair;
}

StereoPair swapped(StereoPair pair) {
  std::swap(pair.left, pair.right);
  return pair;
}

// What is not seen stays in the pose's covariance, also while it is not seen for long.
TEST_F(EgoMotionScenarios, after_a_long_loss_the_pose_remains_uncertain) {
  start();
  const Recorder<tf2_msgs::TFMessage> tf(node_, "/tf");
  nav_msgs::OdometryConstPtr odometry;
  for (int i : {0, 1, 2}) ASSERT_TRUE(odometry = odometryOf(i));
  const double step_s = (street().stamp(2) - street().stamp(1)).toSec();
  double lost_m2 = 0, seconds = 0;
  for (const bool black : {true, false}) {
    for (int k = 0; k < 13; ++k) {
      seconds += step_s;
      // Images that do not change would be frozen ones.
      const StereoPair blind = black ? covered(street().pair(2), static_cast<uint8_t>(30 + k % 2))
                                     : swapped(street().pair(4 + k % 2));
      ASSERT_TRUE(odometry = odometryOf(later(
                      blind, seconds - (blind.left->header.stamp - street().stamp(2)).toSec())));
      EXPECT_TRUE(allFinite(*odometry));
      EXPECT_GT(odometry->pose.covariance[0], lost_m2) << k;
      EXPECT_EQ(odometry->twist.covariance[0], kUnknownVariance) << k;
      lost_m2 = odometry->pose.covariance[0];
    }
    EXPECT_GT(lost_m2, 1);
    EXPECT_TRUE(eventually([&] { return value("EgoMotion", "pose") == "lost"; }));
    // The first one has nothing to be compared with.
    ASSERT_TRUE(odometry = odometryOf(later(street().pair(3), seconds)));
    EXPECT_EQ(odometry->twist.covariance[0], kUnknownVariance);
    seconds += step_s;
    ASSERT_TRUE(odometry = odometryOf(later(street().pair(3), seconds)));
    EXPECT_LT(odometry->twist.covariance[0], 1);
    EXPECT_GE(odometry->pose.covariance[0], lost_m2);
    lost_m2 = odometry->pose.covariance[0];
    seconds += step_s;
  }
  ASSERT_TRUE(eventually([&] {
    return tf.count() > 0 && tf.last()->transforms.at(0).header.stamp == odometry->header.stamp;
  }));
  EXPECT_EQ(tf.last()->transforms[0].transform.translation.x, position(*odometry).x());
}

TEST_F(EgoMotionScenarios, a_gap_is_a_loss) {
  start();
  nav_msgs::OdometryConstPtr odometry;
  for (int i : {0, 1, 2}) ASSERT_TRUE(odometry = odometryOf(i));
  ASSERT_TRUE(odometry = odometryOf(later(street().pair(3), 2)));
  const double gap_m2 = odometry->pose.covariance[0];
  EXPECT_GT(gap_m2, 1);
  EXPECT_LT(gap_m2, 1000);
  ASSERT_TRUE(odometry = odometryOf(later(street().pair(4), 2)));
  EXPECT_LT(odometry->twist.covariance[0], 1);
  EXPECT_GE(odometry->pose.covariance[0], gap_m2);
}

TEST_F(EgoMotionScenarios, a_camera_that_is_too_slow_is_told) {
  start();
  ASSERT_TRUE(odometryOf(0));
  for (int i : {1, 2}) ASSERT_TRUE(odometryOf(later(street().pair(i), 2 * i)));
  EXPECT_TRUE(says("EgoMotion", "frame after frame: no frame for 2.1 s"));
  ASSERT_TRUE(odometryOf(later(street().pair(3), 4)));
  EXPECT_TRUE(says("EgoMotion", "Hz"));
}

TEST_F(EgoMotionScenarios, images_that_freeze_for_ten_seconds_are_told) {
  start();
  nav_msgs::OdometryConstPtr odometry;
  for (int i : {0, 1, 2}) ASSERT_TRUE(odometry = odometryOf(i));
  const Eigen::Vector3d before = position(*odometry);
  for (int k = 1; k <= 20; ++k) {
    ASSERT_TRUE(odometry = odometryOf(later(street().pair(2), 0.5 * k)));
    EXPECT_TRUE(allFinite(*odometry));
    EXPECT_LT((position(*odometry) - before).norm(), 0.01);
    EXPECT_EQ(odometry->pose.covariance[0] == kUnknownVariance, k > 2) << k;
  }
  EXPECT_TRUE(says("EgoMotion", "both images have been the same for more than max_gap = 1 s"));
  EXPECT_TRUE(says("EgoMotion", "or are both lenses covered?"));
  for (int i : {3, 4}) {
    ASSERT_TRUE(odometry = odometryOf(later(street().pair(i), 10)));
    EXPECT_LT(odometry->pose.covariance[0], 1);
    EXPECT_LT((position(*odometry) - truth(0, i).translation()).norm(), 0.05) << i;
  }
  EXPECT_TRUE(eventually([&] { return value("EgoMotion", "inliers") != "0"; }));
}

TEST_F(EgoMotionScenarios, one_image_that_freezes_is_a_loss_and_is_told) {
  start();
  nav_msgs::OdometryConstPtr odometry;
  for (int i : {0, 1, 2}) ASSERT_TRUE(odometry = odometryOf(i));
  const Eigen::Vector3d before = position(*odometry);
  const double step_s = (street().stamp(3) - street().stamp(2)).toSec();
  StereoPair stuck = street().pair(3);
  stuck.left = later(street().pair(2), step_s).left;
  ASSERT_TRUE(odometry = odometryOf(stuck));
  EXPECT_EQ(odometry->twist.covariance[0], kUnknownVariance);
  EXPECT_GT(position(*odometry).x(), before.x() + 0.1) << "it goes on";
  EXPECT_TRUE(says("EgoMotion", "the left image is that of the pair before, the other one is not"));
  ASSERT_TRUE(odometry = odometryOf(4));
  EXPECT_LT(odometry->twist.covariance[0], 1);
  EXPECT_LT((position(*odometry) - truth(0, 4).translation()).norm(), 0.05);
}

TEST_F(EgoMotionScenarios, swapped_images_are_told_and_leave_nothing_behind) {
  start();
  nav_msgs::OdometryConstPtr odometry;
  for (int i : {0, 1}) ASSERT_TRUE(odometry = odometryOf(i));
  const Eigen::Vector3d before = position(*odometry);
  for (int i : {2, 3}) {
    ASSERT_TRUE(odometry = odometryOf(swapped(street().pair(i))));
    EXPECT_TRUE(allFinite(*odometry));
    EXPECT_EQ(odometry->twist.covariance[0], kUnknownVariance);
    EXPECT_GT(position(*odometry).x(), before.x()) << "it goes on";
  }
  EXPECT_TRUE(says("EgoMotion", "the left image shows what the right camera sees"));
  for (int i : {4, 5}) {
    ASSERT_TRUE(odometry = odometryOf(i));
    EXPECT_LT(odometry->pose.covariance[0], 1);
    EXPECT_LT((position(*odometry) - truth(0, i).translation()).norm(), 0.08) << i;
  }
}

TEST_F(EgoMotionScenarios, a_pair_that_is_no_step_is_told_and_the_pose_goes_on) {
  start();
  nav_msgs::OdometryConstPtr odometry;
  for (int i : {0, 1, 3}) ASSERT_TRUE(odometry = odometryOf(i));
  player_.publish(street().pair(3));
  EXPECT_TRUE(says("EgoMotion", "has the stamp of the one before, and is ignored"));
  EXPECT_EQ(level("EgoMotion"), diagnostic_msgs::DiagnosticStatus::WARN);
  player_.publish(street().pair(2));
  EXPECT_TRUE(says("EgoMotion", "s older than the one before, and is ignored"));
  EXPECT_FALSE(odometry_->at(street().stamp(2)));
  for (int i : {4, 5}) {
    ASSERT_TRUE(odometry = odometryOf(i));
    EXPECT_LT((position(*odometry) - truth(0, i).translation()).norm(), 0.08) << i;
  }
}

TEST_F(EgoMotionScenarios, stamps_that_go_back_restart_the_pose_with_a_warning) {
  start();
  const Recorder<rosgraph_msgs::Log> log(ros::NodeHandle(), "/rosout");
  ASSERT_TRUE(eventually([&] { return log.connected(); }));
  for (int i : {0, 1, 2}) ASSERT_TRUE(odometryOf(i));
  const nav_msgs::OdometryConstPtr odometry = odometryOf(later(street().pair(3), -10));
  ASSERT_TRUE(odometry);
  EXPECT_EQ(position(*odometry).norm(), 0);
  EXPECT_TRUE(eventually([&] {
    for (const auto& line : log.messages())
      if (line->msg.find("stamps went back by") != std::string::npos)
        return line->level == rosgraph_msgs::Log::WARN;
    return false;
  }));
}

TEST_F(EgoMotionScenarios, the_twist_is_of_the_time_that_passed) {
  start();
  for (int i : {0, 1}) ASSERT_TRUE(odometryOf(i));
  // Frames 2 and 3 are lost.
  const nav_msgs::OdometryConstPtr odometry = odometryOf(4);
  ASSERT_TRUE(odometry);
  EXPECT_EQ(odometry->header.frame_id, "odom");
  EXPECT_EQ(odometry->child_frame_id, "base_link");
  const double dt_s = (street().stamp(4) - street().stamp(1)).toSec();
  const double speed_mps = truth(1, 4).translation().norm() / dt_s;
  ASSERT_GT(speed_mps, 1);
  EXPECT_NEAR(odometry->twist.twist.linear.x, speed_mps, 0.03 * speed_mps);
  EXPECT_NEAR(odometry->twist.twist.linear.y, 0, 0.1 * speed_mps);
}

TEST_F(EgoMotionScenarios, after_a_reset_the_next_frame_is_the_origin) {
  start();
  for (int i : {0, 1, 2}) ASSERT_TRUE(odometryOf(i));
  EXPECT_GT(position(*odometry_->last()).norm(), 0.5);
  std_srvs::Empty empty;
  ASSERT_TRUE(ros::service::call(ns_ + "/EgoMotion/reset", empty));
  const nav_msgs::OdometryConstPtr origin = odometryOf(3);
  ASSERT_TRUE(origin);
  EXPECT_EQ(position(*origin).norm(), 0);
  const nav_msgs::OdometryConstPtr next = odometryOf(4);
  ASSERT_TRUE(next);
  EXPECT_LT((position(*next) - truth(3, 4).translation()).norm(), 0.05);
}

TEST_F(EgoMotionScenarios, features_on_moving_objects_are_left_out_where_asked) {
  setParam("EgoMotion", "use_moving_mask", true);
  ros::Publisher mask = node_.advertise<sensor_msgs::Image>("moving_objects/mask", 2);
  start();
  ASSERT_TRUE(eventually([&] { return mask.getNumSubscribers() > 0; }));
  for (int i : {0, 1}) ASSERT_TRUE(odometryOf(i));
  EXPECT_LT(odometry_->last()->pose.covariance[0], 1);

  // All of frame 1 is masked, so the motion to the next frame cannot be estimated.
  const cv::Mat1b everything(StreetCamera::kHeight, StreetCamera::kWidth, uchar{255});
  bool lost = false;
  for (int i = 2; i < street().frames() && !lost; ++i) {
    mask.publish(street().image(everything, street().stamp(i - 1)));
    ros::Duration(0.3).sleep();  // its arrival at the nodelet cannot be observed
    const nav_msgs::OdometryConstPtr odometry = odometryOf(i);
    ASSERT_TRUE(odometry);
    lost = odometry->twist.covariance[0] == kUnknownVariance;
  }
  EXPECT_TRUE(lost);
}

TEST_F(EgoMotionScenarios, tf_is_published_only_where_asked) {
  setParam("EgoMotion", "publish_tf", false);
  start();
  const Recorder<tf2_msgs::TFMessage> tf(node_, "/tf");
  for (int i : {0, 1}) ASSERT_TRUE(odometryOf(i));
  EXPECT_TRUE(eventually([&] { return !tf.connected(); }, 5));
  EXPECT_EQ(tf.count(), 0u);
}

sensor_msgs::Imu imuAt(ros::Time stamp, const std::string& frame) {
  sensor_msgs::Imu imu;
  imu.header.stamp = stamp;
  imu.header.frame_id = frame;
  return imu;
}

TEST_F(EgoMotionScenarios, a_gyroscope_is_taken_and_what_it_lacks_is_told) {
  setParam("EgoMotion", "use_imu", true);
  start();
  ASSERT_TRUE(odometryOf(0));
  ASSERT_TRUE(odometryOf(1)) << "ego-motion uses the images only";
  EXPECT_TRUE(says("EgoMotion", "use_imu: nobody publishes sensor_msgs/Imu on " + ns_ +
                                    "/imu (launch argument imu:="));

  ros::Publisher imu = node_.advertise<sensor_msgs::Imu>("imu", 500);
  ASSERT_TRUE(eventually([&] { return imu.getNumSubscribers() > 0; }));
  const auto send = [&](double from_s, double to_s, const std::string& frame) {
    for (double t_s = from_s; t_s <= to_s; t_s += 0.005)
      imu.publish(imuAt(street().stamp(0) + ros::Duration(t_s), frame));
    ros::WallDuration(0.1).sleep();  // its arrival at the nodelet cannot be observed
  };
  send(-0.1, 0.35, "unmounted_imu");
  ASSERT_TRUE(odometryOf(2));
  EXPECT_TRUE(says("EgoMotion", "use_imu: no transform from the left camera"));
  EXPECT_TRUE(says("EgoMotion", "the IMU's frame 'unmounted_imu'"));

  geometry_msgs::TransformStamped mount;
  mount.header.frame_id = "base_link";
  mount.child_frame_id = "imu";
  mount.transform.rotation.w = 1;
  const StaticTransform mounted(mount);
  send(0.36, 0.45, "imu");
  send(0.46, 0.47, "imu");
  ASSERT_TRUE(eventually([&] {
    return odometryOf(3) && !diagnostics_.says(ns_.substr(1) + "/EgoMotion", "use_imu");
  }));
  // Stamps that go back by more than 0.5 s.
  send(-0.3, -0.2, "imu");
  ASSERT_TRUE(odometryOf(4));
  EXPECT_TRUE(says("EgoMotion", "its last stamp is before the image's"));
  EXPECT_TRUE(says("EgoMotion", "ego-motion uses the images only"));
  EXPECT_LT((position(*odometry_->last()) - truth(0, 4).translation()).norm(), 0.05);
}

// A driver that hangs sends the same images again, while the robot may turn.
TEST_F(EgoMotionScenarios, images_that_repeat_teach_no_gyroscope) {
  setParam("EgoMotion", "use_imu", true);
  setParam("EgoMotion", "base_frame", "");
  start();
  ros::Publisher imu = node_.advertise<sensor_msgs::Imu>("imu", 500);
  ASSERT_TRUE(eventually([&] { return imu.getNumSubscribers() > 0; }));
  const std::string camera = street().pair(0).left->header.frame_id;
  for (double t_s = -0.1; t_s <= 1; t_s += 0.005)
    imu.publish(imuAt(street().stamp(0) + ros::Duration(t_s), camera));
  ros::WallDuration(0.2).sleep();  // its arrival at the nodelet cannot be observed
  for (int k = 0; k < 4; ++k) ASSERT_TRUE(odometryOf(later(street().pair(0), 0.1 * k)));
  EXPECT_TRUE(eventually([&] { return value("EgoMotion", "frames") == "4"; }));
  EXPECT_EQ(value("EgoMotion", "gyro bias [deg/s]"), "");
}

TEST_F(EgoMotionScenarios, a_guess_frame_that_does_not_exist_is_told) {
  setParam("EgoMotion", "guess_frame", "nowhere");
  start();
  for (int i : {0, 1, 2}) ASSERT_TRUE(odometryOf(i));
  EXPECT_TRUE(says("EgoMotion", "relative to guess_frame 'nowhere'"));
  EXPECT_TRUE(says("EgoMotion", "set guess_frame to the fixed frame of another odometry"));
  EXPECT_TRUE(says("EgoMotion", "ego-motion uses the images only"));
  EXPECT_LT((position(*odometry_->last()) - truth(0, 2).translation()).norm(), 0.05);
}

TEST_F(EgoMotionScenarios, a_guess_frame_that_was_late_once_is_waited_for_again) {
  setParam("EgoMotion", "guess_frame", "wheels");
  setParam("EgoMotion", "publish_tf", false);
  start();
  for (int i : {0, 1}) ASSERT_TRUE(odometryOf(i));
  ASSERT_TRUE(says("EgoMotion", "guess_frame 'wheels'"));
  tf2_ros::TransformBroadcaster wheels;
  const auto send = [&](double t_s) {
    wheels.sendTransform(transformMsg(street().stamp(0) + ros::Duration(t_s), "wheels", "base_link",
                                      Eigen::Isometry3d::Identity()));
  };
  double t_s = 1;
  EXPECT_TRUE(eventually([&] {
    t_s += 0.1;
    send(t_s - 0.03);
    std::thread late([&] {
      ros::WallDuration(0.02).sleep();
      send(t_s);
    });
    const bool done = odometryOf(later(street().pair(0), t_s)) != nullptr;
    late.join();
    return done && !diagnostics_.says(ns_.substr(1) + "/EgoMotion", "guess_frame");
  }));
}

TEST_F(EgoMotionScenarios, who_moves_the_base_later_is_told_and_left_alone) {
  start();
  const Recorder<tf2_msgs::TFMessage> tf(node_, "/tf");
  for (int i : {0, 1}) ASSERT_TRUE(odometryOf(i));
  const auto ours = [&] {
    size_t count = 0;
    for (const auto& message : tf.messages())
      count += message->transforms.at(0).header.frame_id == "odom";
    return count;
  };
  ASSERT_TRUE(eventually([&] { return ours() == 2; }, 5));

  tf2_ros::TransformBroadcaster wheels;
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = street().stamp(1);
  transform.header.frame_id = "wheel_odom";
  transform.child_frame_id = "base_link";
  transform.transform.rotation.w = 1;
  wheels.sendTransform(transform);
  ASSERT_TRUE(eventually([&] { return tf.count() == 3; }, 5));
  ros::WallDuration(0.2).sleep();  // its arrival at the nodelet cannot be observed
  for (int i : {2, 3, 4}) ASSERT_TRUE(odometryOf(i)) << "the odometry goes on";
  EXPECT_TRUE(says("EgoMotion", "already moves 'base_link' in 'wheel_odom'"));
  EXPECT_TRUE(says("EgoMotion", "launch with ego_motion:=false odom_frame:=wheel_odom"));
  EXPECT_EQ(ours(), 2u);
}

TEST_F(EgoMotionScenarios, a_base_that_is_fixed_to_another_frame_is_told_at_the_start) {
  geometry_msgs::TransformStamped footprint;
  footprint.header.frame_id = "base_footprint";
  footprint.child_frame_id = "base_link";
  footprint.transform.rotation.w = 1;
  const StaticTransform fixed(footprint);
  const Recorder<tf2_msgs::TFMessage> tf(node_, "/tf");
  start();
  ros::WallDuration(0.2).sleep();  // its arrival at the nodelet cannot be observed
  for (int i : {0, 1}) ASSERT_TRUE(odometryOf(i));
  EXPECT_TRUE(says("EgoMotion", "has 'base_link' fixed to 'base_footprint'"));
  EXPECT_TRUE(says("EgoMotion", "Set base_frame to 'base_footprint'"));
  EXPECT_EQ(tf.count(), 0u);
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "ego_motion_scenarios_test");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
