/// The nodelets' diagnostics name the faults that occur on robots, and their cure.
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <sensor_msgs/CompressedImage.h>
#include <tf2_ros/transform_broadcaster.h>

#include <chrono>

#include "changed_pairs.h"
#include "nodelet_fixture.h"

namespace predictive_stereo {
namespace {

using Diagnosis = NodeletTest;

TEST_F(Diagnosis, a_topic_that_nobody_publishes_is_named) {
  setParam("Disparity", "queue_size", 5);
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  player_.shutDownRight();
  EXPECT_TRUE(says("Disparity", "nobody publishes " + ns_ + "/right/image_rect"));
  EXPECT_TRUE(says("Disparity", "camera:="));
}

TEST_F(Diagnosis, a_topic_that_is_advertised_but_silent_is_named) {
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  ASSERT_TRUE(player_.waitForSubscribers());
  StereoPair pair = street().pair(0);
  for (int round = 0; round < 40; ++round) {
    auto left = boost::make_shared<sensor_msgs::Image>(*pair.left);
    left->header.stamp += ros::Duration(0.1 * round);
    player_.publishLeft(left);
    ros::WallDuration(0.1).sleep();
  }
  EXPECT_TRUE(says("Disparity", "no messages arrive on " + ns_ + "/left/camera_info, " + ns_ +
                                    "/right/image_rect, " + ns_ + "/right/camera_info"));
  EXPECT_TRUE(says("Disparity", "is the camera running, or is the bag paused?"));
}

TEST_F(Diagnosis, moving_objects_names_the_nodelet_that_it_waits_for) {
  load("MovingObjects");
  Recorder<MovingObjectArray> objects(node_, "moving_objects");
  const std::string measured =
      "nobody publishes " + ns_ + "/measured_disparity, " + ns_ + "/measured_variance";
  const std::string cure = ": run the camera driver and the Disparity nodelet in this namespace";
  EXPECT_TRUE(says("MovingObjects", measured + cure));
  const Recorder<sensor_msgs::Image> residual(node_, "moving_objects/residual");
  EXPECT_TRUE(says("MovingObjects", measured + ", " + ns_ + "/predicted_disparity, " + ns_ +
                                        "/predicted_variance" + cure));
}

TEST_F(Diagnosis, moving_objects_tells_that_the_camera_has_stopped) {
  load("Disparity");
  load("MovingObjects");
  DisparityRecorder disparity(node_, "disparity");
  Recorder<MovingObjectArray> objects(node_, "moving_objects");
  ASSERT_TRUE(player_.waitForSubscribers());
  ASSERT_TRUE(publishesDisparity(street().pair(0), disparity));
  EXPECT_TRUE(says("MovingObjects", "no messages arrive on " + ns_ + "/left/image_rect although"));
  EXPECT_TRUE(says("MovingObjects", "is the camera running, or is the bag paused?"));
}

TEST_F(Diagnosis, moving_objects_without_tf_are_not_found_which_is_told) {
  setParam("MovingObjects", "odom_frame", "nowhere");
  load("Disparity");
  load("MovingObjects");
  Recorder<MovingObjectArray> objects(node_, "moving_objects");
  ASSERT_TRUE(player_.waitForSubscribers());
  ASSERT_TRUE(eventually([&] { return objects.connected(); }));
  // Messages published before the two nodelets are connected are lost.
  int index = 0;
  ASSERT_TRUE(eventually([&] {
    player_.publish(street().pair(index++ % 6));
    return eventually([&] { return objects.count() > 0; }, 1);
  }));
  EXPECT_TRUE(
      says("MovingObjects", "relative to odom_frame 'nowhere' at the image's stamp within"));
  EXPECT_TRUE(says("MovingObjects", ": no moving objects are found"));
  EXPECT_TRUE(
      says("MovingObjects", "Run the EgoMotion nodelet with publish_tf, or set odom_frame"));
}

TEST_F(Diagnosis, a_calibration_whose_stamp_differs_is_taken_by_all) {
  load("Disparity");
  load("MovingObjects");
  DisparityRecorder disparity(node_, "disparity");
  Recorder<MovingObjectArray> objects(node_, "moving_objects");
  ASSERT_TRUE(player_.waitForSubscribers());
  ASSERT_TRUE(eventually([&] { return objects.connected(); }));
  int index = 0;
  EXPECT_TRUE(eventually([&] {
    StereoPair pair = street().pair(index++ % 6);
    changeInfos(pair,
                [](sensor_msgs::CameraInfo& info) { info.header.stamp += ros::Duration(0.002); });
    player_.publish(pair);
    return eventually([&] { return objects.count() > 0; }, 1);
  }));
}

// Frames come at the camera's rate, and not once per transform_timeout.
TEST_F(Diagnosis, a_motion_that_nobody_publishes_is_not_waited_for_in_each_frame) {
  setParam("Disparity", "odom_frame", "nowhere");
  setParam("Disparity", "transform_timeout", 5.0);
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  ASSERT_TRUE(player_.waitForSubscribers());
  ASSERT_TRUE(publishesDisparity(street().pair(0), disparity));
  ASSERT_TRUE(publishesDisparity(street().pair(1), disparity)) << "it waits for five seconds";
  const auto begin = std::chrono::steady_clock::now();
  for (int i : {2, 3, 4, 5}) ASSERT_TRUE(publishesDisparity(street().pair(i), disparity));
  const std::chrono::duration<double> four = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(four.count(), 10);
  EXPECT_TRUE(says("Disparity", "matched without prediction"));
}

TEST_F(Diagnosis, an_odometry_that_was_chosen_but_is_absent_is_told) {
  ASSERT_TRUE(loader_->load(ns_ + "/Disparity", "predictive_stereo/Disparity",
                            {{ns_ + "/odometry", "/nowhere"}}, {}));
  DisparityRecorder disparity(node_, "disparity");
  ASSERT_TRUE(player_.waitForSubscribers());
  for (const int frame : {0, 1}) ASSERT_TRUE(publishesDisparity(street().pair(frame), disparity));
  EXPECT_TRUE(
      says("Disparity",
           "nobody publishes nav_msgs/Odometry on /nowhere (launch argument odometry:=<topic>)"));
}

TEST_F(Diagnosis, an_odometry_whose_child_frame_tf_does_not_have_is_told) {
  ros::Publisher wheels = node_.advertise<nav_msgs::Odometry>("wheels", 10);
  const StaticTransform extrinsic(street().extrinsic());
  setParam("Disparity", "transform_timeout", 2.0);  // EgoMotion is slow under a sanitizer
  load("EgoMotion");
  ASSERT_TRUE(loader_->load(ns_ + "/Disparity", "predictive_stereo/Disparity",
                            {{ns_ + "/odometry", ns_ + "/wheels"}}, {}));
  DisparityRecorder disparity(node_, "disparity");
  ASSERT_TRUE(player_.waitForSubscribers());
  nav_msgs::Odometry odometry;
  odometry.child_frame_id = "nowhere";
  for (const int frame : {0, 1, 2, 3}) {
    odometry.header.stamp = street().stamp(frame);
    wheels.publish(odometry);
    ASSERT_TRUE(publishesDisparity(street().pair(frame), disparity));
  }
  EXPECT_TRUE(says("Disparity", "child_frame_id 'nowhere' of odometry has no transform to '"));
}

TEST_F(Diagnosis, stamps_that_differ_are_told_with_the_cure) {
  setParam("Disparity", "approximate_sync", false);
  setParam("EgoMotion", "sync_tolerance", 0.001);
  load("Disparity");
  load("EgoMotion");
  DisparityRecorder disparity(node_, "disparity");
  ASSERT_TRUE(player_.waitForSubscribers());
  for (int round = 0; round < 40; ++round) {
    StereoPair pair = street().pair(0);
    auto left = boost::make_shared<sensor_msgs::Image>(*pair.left);
    auto left_info = boost::make_shared<sensor_msgs::CameraInfo>(*pair.left_info);
    auto right = boost::make_shared<sensor_msgs::Image>(*pair.right);
    auto right_info = boost::make_shared<sensor_msgs::CameraInfo>(*pair.right_info);
    left->header.stamp = left_info->header.stamp = street().stamp(0) + ros::Duration(0.1 * round);
    right->header.stamp = right_info->header.stamp = left->header.stamp + ros::Duration(0.004);
    player_.publish({left, right, left_info, right_info});
    ros::WallDuration(0.1).sleep();
  }
  EXPECT_TRUE(says("Disparity", "by 4 ms or more"));
  EXPECT_TRUE(says("Disparity", "set approximate_sync to true"));
  EXPECT_TRUE(says("EgoMotion", "sync_tolerance allows 1 ms: set sync_tolerance above"));
  EXPECT_EQ(disparity.count(), 0u);
}

TEST_F(Diagnosis, left_images_without_partners_are_told) {
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  ASSERT_TRUE(player_.waitForSubscribers());
  for (int i = 0; i < 60; ++i) {
    const StereoPair pair = withStamp(street().pair(0), street().stamp(0) + ros::Duration(0.1 * i));
    if (i % 3 == 0)
      ASSERT_TRUE(publishesDisparity(pair, disparity));
    else
      player_.publishLeft(pair.left);
  }
  EXPECT_TRUE(says("Disparity", "more than half of the left images find no partners"));
}

TEST_F(Diagnosis, a_missing_extrinsic_is_waited_for) {
  load("EgoMotion");
  Recorder<nav_msgs::Odometry> odometry(node_, "odometry");
  ASSERT_TRUE(player_.waitForSubscribers());
  StereoPair pair = street().pair(0);
  // A separate frame, because tf has the extrinsics of other tests.
  const auto withFrame = [](const auto& message) {
    auto copy = boost::make_shared<std::decay_t<decltype(*message)>>(*message);
    copy->header.frame_id = "unmounted_camera";
    return copy;
  };
  const auto unmounted = [&](int index) {
    const StereoPair pair = street().pair(index);
    return StereoPair{withFrame(pair.left), withFrame(pair.right), withFrame(pair.left_info),
                      withFrame(pair.right_info)};
  };
  player_.publish(unmounted(0));
  EXPECT_TRUE(says("EgoMotion", "no transform from base_frame 'base_link'"));
  EXPECT_TRUE(says("EgoMotion", "set base_frame to 'unmounted_camera'"));
  EXPECT_EQ(odometry.count(), 0u);

  geometry_msgs::TransformStamped extrinsic = street().extrinsic();
  extrinsic.child_frame_id = "unmounted_camera";
  StaticTransform mounted(extrinsic);
  player_.publish(unmounted(1));
  EXPECT_TRUE(eventually([&] { return odometry.count() > 0; }, 10));
}

TEST_F(Diagnosis, an_extrinsic_that_is_late_is_told_from_one_that_is_absent) {
  load("EgoMotion");
  ASSERT_TRUE(player_.waitForSubscribers());
  StereoPair pair = street().pair(1);
  auto left = boost::make_shared<sensor_msgs::Image>(*pair.left);
  left->header.frame_id = "panned_camera";
  pair.left = left;
  tf2_ros::TransformBroadcaster broadcaster;
  geometry_msgs::TransformStamped extrinsic = street().extrinsic();
  extrinsic.child_frame_id = "panned_camera";
  extrinsic.header.stamp = street().stamp(0);
  // The nodelet may not have connected to the broadcaster yet.
  EXPECT_TRUE(eventually([&] {
    broadcaster.sendTransform(extrinsic);
    player_.publish(pair);
    return diagnostics_.says(ns_.substr(1) + "/EgoMotion", "older than the image");
  }));
}

TEST_F(Diagnosis, refused_parameters_are_told_and_the_manager_lives) {
  setParam("Disparity", "matcher/p1", 500);
  load("Disparity");
  EXPECT_TRUE(says("Disparity", ns_ + "/Disparity/matcher/p1 = 500: must be within [1, 200]"));
  setParam("EgoMotion", "features", "many");
  load("EgoMotion");
  EXPECT_TRUE(says("EgoMotion", "features = many"));
  setParam("MovingObjects", "queue_size", 0);
  load("MovingObjects");
  EXPECT_TRUE(says("MovingObjects", "queue_size = 0"));
}

TEST_F(Diagnosis, a_target_without_simd_is_told_with_the_cure) {
  setParam("Disparity", "matcher/simd_target", "scalar");
  load("Disparity");
  EXPECT_TRUE(says("Disparity", "simd_target is scalar: no SIMD instructions are used"));
  EXPECT_TRUE(says("Disparity", "Cure: set simd_target to auto"));
}

TEST_F(Diagnosis, a_computer_that_is_too_slow_is_told) {
  setParam("Disparity", "matcher/simd_target", "scalar");
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  ASSERT_TRUE(player_.waitForSubscribers());
  EXPECT_TRUE(eventually(
      [&, stamp = street().stamp(0)]() mutable {
        player_.publish(withStamp(street().pair(0), stamp += ros::Duration(0.01)));
        return diagnostics_.says(ns_.substr(1) + "/Disparity", "half of the pairs are dropped");
      },
      60));
}

TEST_F(Diagnosis, a_transport_without_its_plugin_is_told_and_the_manager_lives) {
  setParam("Disparity", "image_transport", "smoke_signals");
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  EXPECT_TRUE(says("Disparity", "image_transport = smoke_signals: cannot be used"));
}

TEST_F(Diagnosis, the_name_of_compressed_images_is_told_with_the_cure) {
  const std::string compressed = ns_ + "/left/image_rect/compressed";
  ASSERT_TRUE(loader_->load(ns_ + "/Disparity", "predictive_stereo/Disparity",
                            {{ns_ + "/left/image_rect", compressed}}, {}));
  const DisparityRecorder disparity(node_, "disparity");
  EXPECT_TRUE(
      says("Disparity", compressed + " has no raw images: give its name without /compressed"));
}

TEST_F(Diagnosis, images_that_cannot_be_unpacked_are_told) {
  setParam("Disparity", "image_transport", "compressed");
  ros::Publisher left =
      node_.advertise<sensor_msgs::CompressedImage>("left/image_rect/compressed", 5);
  ros::Publisher right =
      node_.advertise<sensor_msgs::CompressedImage>("right/image_rect/compressed", 5);
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  ASSERT_TRUE(eventually([&] { return left.getNumSubscribers() > 0; }));
  sensor_msgs::CompressedImage broken;
  broken.header.stamp = street().stamp(0);
  broken.format = "mono8; jpeg compressed ";
  broken.data = {1, 2, 3};
  left.publish(broken);
  EXPECT_TRUE(says("Disparity", "left/image_rect/compressed: compressed image of format"));
  EXPECT_TRUE(says("Disparity", "neither JPEG nor PNG"));
}

TEST_F(Diagnosis, bad_pairs_are_told_and_good_ones_go_on) {
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  ASSERT_TRUE(player_.waitForSubscribers());

  StereoPair encoded = street().pair(0);
  auto unknown = boost::make_shared<sensor_msgs::Image>(*encoded.left);
  unknown->encoding = "yuv444";
  encoded.left = unknown;
  player_.publish(encoded);
  EXPECT_TRUE(says("Disparity", "left image has encoding 'yuv444'"));

  StereoPair swapped = street().pair(1);
  std::swap(swapped.left_info, swapped.right_info);
  player_.publish(swapped);
  EXPECT_TRUE(says("Disparity", "are left and right swapped"));
  EXPECT_TRUE(says("Disparity", "P_right"));

  StereoPair uncalibrated = street().pair(1);
  for (auto* camera : {&uncalibrated.left_info, &uncalibrated.right_info}) {
    auto empty = boost::make_shared<sensor_msgs::CameraInfo>(**camera);
    empty->P.fill(0);
    *camera = empty;
  }
  player_.publish(uncalibrated);
  EXPECT_TRUE(says("Disparity", "px is not positive; is the camera calibrated?"));

  StereoPair narrow = street().pair(2);
  auto cropped = boost::make_shared<sensor_msgs::Image>(*narrow.right);
  cropped->width -= 16;
  narrow.right = cropped;
  player_.publish(narrow);
  EXPECT_TRUE(says("Disparity", "the right one is 400x128"));

  StereoPair short_data = street().pair(3);
  auto truncated = boost::make_shared<sensor_msgs::Image>(*short_data.left);
  truncated->data.resize(100);
  short_data.left = truncated;
  player_.publish(short_data);
  EXPECT_TRUE(says("Disparity", "left image is broken"));

  EXPECT_EQ(disparity.count(), 0u);
  EXPECT_TRUE(publishesDisparity(street().pair(4), disparity));
  EXPECT_TRUE(eventually([&] {
    return diagnostics_.of(ns_.substr(1) + "/Disparity").level ==
           diagnostic_msgs::DiagnosticStatus::OK;
  }));
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "diagnosis_test");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
