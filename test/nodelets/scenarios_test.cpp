/// The nodelets in situations that occur on robots.
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <ros/network.h>
#include <ros/xmlrpc_manager.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_srvs/Empty.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "changed_pairs.h"
#include "nodelets/stereo_messages.h"
#include "posed_camera.h"

namespace predictive_stereo {
namespace {

class Scenarios : public PosedCameraTest {};

TEST_F(Scenarios, without_tf_disparity_comes_without_prediction) {
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity"), predicted(node_, "predicted_disparity");
  ASSERT_TRUE(player_.waitForSubscribers());
  ASSERT_TRUE(publishesDisparity(street().pair(0), disparity));
  ASSERT_TRUE(publishesDisparity(street().pair(1), disparity));
  EXPECT_GT(validPixels(*disparity.last()), StreetCamera::kWidth * StreetCamera::kHeight / 2u);
  EXPECT_EQ(validPixels(*predicted.at(street().stamp(1))), 0u);
  EXPECT_TRUE(says("Disparity", "relative to odom_frame 'odom'"));
  EXPECT_TRUE(says("Disparity", "within transform_timeout = 0.2 s: matched without prediction"));
  EXPECT_TRUE(says("Disparity", "Run the EgoMotion nodelet with publish_tf, or set odom_frame"));
}

TEST_F(Scenarios, nodelets_may_be_unloaded_while_frames_come) {
  std::atomic<bool> done{false};
  std::thread camera([&] {
    for (int i = 0; !done; ++i) {
      StereoPair pair = street().pair(i % 6);
      player_.publish(pair);
      ros::WallDuration(0.002).sleep();
    }
  });
  for (int round = 0; round < 4; ++round) {
    for (const char* nodelet : {"EgoMotion", "Disparity", "MovingObjects"}) load(nodelet);
    DisparityRecorder disparity(node_, "disparity");
    Recorder<MovingObjectArray> objects(node_, "moving_objects");
    EXPECT_TRUE(eventually([&] { return disparity.count() > 0; }));
    for (const char* nodelet : {"EgoMotion", "Disparity", "MovingObjects"})
      EXPECT_TRUE(loader_->unload(ns_ + "/" + nodelet));
  }
  done = true;
  camera.join();
}

TEST_F(Scenarios, stamps_that_differ_a_little_make_pairs_at_once) {
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  ASSERT_TRUE(player_.waitForSubscribers());
  StereoPair pair = street().pair(0);
  auto right = boost::make_shared<sensor_msgs::Image>(*pair.right);
  auto right_info = boost::make_shared<sensor_msgs::CameraInfo>(*pair.right_info);
  right->header.stamp = right_info->header.stamp = pair.left->header.stamp + ros::Duration(0.004);
  pair.right = right;
  pair.right_info = right_info;
  EXPECT_TRUE(publishesDisparity(pair, disparity)) << "a frame late?";
}

TEST_F(Scenarios, the_camera_may_be_its_own_base) {
  setParam("EgoMotion", "base_frame", "");
  setParam("EgoMotion", "publish_tf", false);
  load("EgoMotion");
  Recorder<nav_msgs::Odometry> odometry(node_, "odometry");
  ASSERT_TRUE(player_.waitForSubscribers());
  for (int i = 0; i < 4; ++i) {
    player_.publish(street().pair(i));
    ASSERT_TRUE(eventually([&] { return odometry.count() == static_cast<size_t>(i + 1); }, 10));
  }
  EXPECT_EQ(odometry.last()->child_frame_id, StreetCamera::kFrame);
  // REP 103: x is ahead.
  const Eigen::Isometry3d truth = street().T_world_base(0).inverse() * street().T_world_base(3);
  EXPECT_NEAR(odometry.last()->pose.pose.position.x, truth.translation().x(),
              0.05 * truth.translation().norm() + 0.02);
  // The twist is in the child frame, that of the camera: z is ahead.
  EXPECT_GT(odometry.last()->twist.twist.linear.z, 1.0);
}

TEST_F(Scenarios, colour_images_are_taken_as_grey) {
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  ASSERT_TRUE(player_.waitForSubscribers());
  ASSERT_TRUE(publishesDisparity(street().pair(0), disparity));
  const auto grey = disparity.last();
  disparity.clear();
  const auto coloured = [](const sensor_msgs::Image& image, const char* encoding, size_t channels) {
    auto result = boost::make_shared<sensor_msgs::Image>(image);
    result->encoding = encoding;
    result->step = static_cast<uint32_t>(image.step * channels);
    result->data.clear();
    for (const uint8_t value : image.data) result->data.insert(result->data.end(), channels, value);
    return result;
  };
  int index = 0;
  for (const auto& [encoding, channels] :
       std::vector<std::pair<const char*, size_t>>{{"bgr8", 3}, {"rgb8", 3}, {"bgra8", 4}}) {
    // Because of the gap, every frame is a first one.
    const ros::Time stamp = street().stamp(0) + ros::Duration(10.0 * ++index);
    StereoPair pair = street().pair(0);
    auto left = coloured(*pair.left, encoding, channels);
    auto right = coloured(*pair.right, encoding, channels);
    auto left_info = boost::make_shared<sensor_msgs::CameraInfo>(*pair.left_info);
    auto right_info = boost::make_shared<sensor_msgs::CameraInfo>(*pair.right_info);
    left->header.stamp = right->header.stamp = stamp;
    left_info->header.stamp = right_info->header.stamp = stamp;
    ASSERT_TRUE(publishesDisparity({left, right, left_info, right_info}, disparity)) << encoding;
    EXPECT_TRUE(disparity.last()->image.data == grey->image.data) << encoding;
  }
}

TEST_F(Scenarios, compressed_images_need_no_plugin) {
  for (const char* nodelet : {"EgoMotion", "Disparity", "MovingObjects"})
    setParam(nodelet, "image_transport", "compressed");
  setParam("Disparity", "transform_timeout", 10.0);  // the thread sanitizer is slow
  for (const char* nodelet : {"EgoMotion", "Disparity", "MovingObjects"}) load(nodelet);
  const StaticTransform extrinsic(street().extrinsic());
  using sensor_msgs::CompressedImage;
  ros::Publisher left = node_.advertise<CompressedImage>("left/image_rect/compressed", 5),
                 right = node_.advertise<CompressedImage>("right/image_rect/compressed", 5);
  DisparityRecorder disparity(node_, "disparity");
  Recorder<MovingObjectArray> objects(node_, "moving_objects");
  Recorder<nav_msgs::Odometry> odometry(node_, "odometry");
  ASSERT_TRUE(eventually([&] {
    return left.getNumSubscribers() > 0 && right.getNumSubscribers() > 0 && objects.connected();
  }));
  ros::WallDuration(1).sleep();  // until the three are connected
  const auto packed = [](const sensor_msgs::Image& image) {
    CompressedImage message;
    message.header = image.header;
    message.format = "mono8; png compressed ";
    cv::imencode(".png", greyImage(image, "left"), message.data);
    return message;
  };
  for (int i = 0; i < 3; ++i) {
    const StereoPair pair = street().pair(i);
    player_.publishInfos(pair);
    left.publish(packed(*pair.left));
    right.publish(packed(*pair.right));
    ASSERT_TRUE(eventually([&] {
      return objects.at(street().stamp(i)) && disparity.at(street().stamp(i)) &&
             odometry.at(street().stamp(i));
    })) << i;
  }
  EXPECT_GT(validPixels(*disparity.last()), StreetCamera::kWidth * StreetCamera::kHeight / 2u);
  EXPECT_TRUE(eventually([&] { return value("Disparity", "predicted") == "yes"; }));
}

TEST_F(Scenarios, a_bag_in_a_loop_gives_the_same_again) {
  setParam("Disparity", "transform_timeout", 10.0);  // the thread sanitizer is slow
  load("EgoMotion");
  load("Disparity");
  StaticTransform extrinsic(street().extrinsic());
  DisparityRecorder disparity(node_, "disparity");
  Recorder<nav_msgs::Odometry> odometry(node_, "odometry");
  ASSERT_TRUE(player_.waitForSubscribers());
  std::vector<stereo_msgs::DisparityImageConstPtr> first;
  std::vector<nav_msgs::OdometryConstPtr> first_odometry;
  for (int i = 0; i < 4; ++i) {
    // Later, as a bag of 0.3 s would count as pairs in the wrong order.
    const ros::Time stamp = street().stamp(i) + ros::Duration(1);
    ASSERT_TRUE(publishesDisparity(withStamp(street().pair(i), stamp), disparity));
    ASSERT_TRUE(eventually([&] { return odometry.count() == static_cast<size_t>(i + 1); }, 10));
    first.push_back(disparity.last());
    first_odometry.push_back(odometry.last());
  }
  disparity.clear();
  odometry.clear();
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(publishesDisparity(street().pair(i), disparity));
    ASSERT_TRUE(eventually([&] { return odometry.count() == static_cast<size_t>(i + 1); }, 10));
    EXPECT_TRUE(disparity.last()->image.data == first[i]->image.data) << "frame " << i;
    EXPECT_TRUE(odometry.last()->pose == first_odometry[i]->pose) << "frame " << i;
  }
}

TEST_F(Scenarios, disparity_waits_for_what_moves_and_does_not_predict_from_it) {
  setParam("Disparity", "odom_frame", "world_of_others");
  setParam("Disparity", "transform_timeout", 10.0);
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  Recorder<sensor_msgs::Image> ranges(node_, "search_range");
  ros::Publisher masks = node_.advertise<sensor_msgs::Image>("moving_objects/mask", 2);
  ASSERT_TRUE(player_.waitForSubscribers());
  ASSERT_TRUE(eventually([&] { return masks.getNumSubscribers() > 0; }));
  tf2_ros::TransformBroadcaster broadcaster;
  std::vector<sensor_msgs::ImageConstPtr> widths;
  for (const uint8_t moving : {0, 255}) {
    // Another camera, so that the same stamps can be used again.
    const std::string camera = "camera_" + std::to_string(moving);
    disparity.clear();
    ranges.clear();
    std_srvs::Empty empty;
    ASSERT_TRUE(ros::service::call(ns_ + "/Disparity/reset", empty));
    ASSERT_TRUE(publishesDisparity(moved(0, camera, broadcaster), disparity));
    player_.publish(moved(1, camera, broadcaster));
    EXPECT_FALSE(eventually([&] { return disparity.at(street().stamp(1)) != nullptr; }, 0.5));
    auto mask = boost::make_shared<sensor_msgs::Image>(*street().pair(0).left);
    mask->data.assign(mask->data.size(), moving);
    masks.publish(mask);
    ASSERT_TRUE(eventually([&] { return ranges.at(street().stamp(1)) != nullptr; }, 10));
    widths.push_back(ranges.at(street().stamp(1)));
  }
  EXPECT_FALSE(widths[0]->data == widths[1]->data);
}

TEST_F(Scenarios, the_static_cloud_leaves_out_what_moves) {
  setParam("Disparity", "points/stride", 2);
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  Recorder<sensor_msgs::PointCloud2> all(node_, "points2"), still(node_, "points2_static");
  ros::Publisher masks = node_.advertise<sensor_msgs::Image>("moving_objects/mask", 2);
  ASSERT_TRUE(player_.waitForSubscribers());
  ASSERT_TRUE(eventually([&] { return masks.getNumSubscribers() > 0; }));
  ASSERT_TRUE(publishesDisparity(street().pair(0), disparity));
  EXPECT_FALSE(eventually([&] { return still.count() > 0; }, 0.5)) << "what moves is not known yet";
  cv::Mat1b moving(StreetCamera::kHeight, StreetCamera::kWidth, uchar{0});
  moving.colRange(100, 200).setTo(255);
  masks.publish(street().image(moving, street().stamp(0)));
  ASSERT_TRUE(eventually([&] { return all.count() == 1 && still.count() == 1; }));
  const auto &with = *all.last(), &without = *still.last();
  EXPECT_EQ(without.header.stamp, street().stamp(0));
  EXPECT_EQ(without.header.frame_id, StreetCamera::kFrame);
  ASSERT_EQ(without.width, StreetCamera::kWidth / 2u);
  ASSERT_EQ(without.height, StreetCamera::kHeight / 2u);
  ASSERT_EQ(without.data.size(), with.data.size());
  size_t left_out = 0;
  for (size_t i = 0; i < without.width * without.height; ++i) {
    const bool moves = i % without.width >= 50 && i % without.width < 100;
    float x = 0, expected = 0;
    std::memcpy(&x, &without.data[i * without.point_step], sizeof(x));
    std::memcpy(&expected, &with.data[i * with.point_step], sizeof(x));
    left_out += moves && std::isfinite(expected);
    EXPECT_TRUE(moves || !std::isfinite(expected) ? std::isnan(x) : x == expected) << i;
  }
  EXPECT_GT(left_out, 1000u);
}

TEST_F(Scenarios, without_masks_there_is_no_static_cloud_and_that_is_told) {
  load("Disparity");
  DisparityRecorder disparity(node_, "disparity");
  const Recorder<sensor_msgs::PointCloud2> still(node_, "points2_static");
  ASSERT_TRUE(player_.waitForSubscribers());
  for (int round = 0; round < 2; ++round)
    for (int i = 0; i < street().frames(); ++i) {
      disparity.clear();
      const ros::Time stamp = street().stamp(i) + ros::Duration(round);
      ASSERT_TRUE(publishesDisparity(withStamp(street().pair(i), stamp), disparity));
    }
  EXPECT_TRUE(says("Disparity", "points2_static is not published, as the mask of moving objects"));
  EXPECT_TRUE(says("Disparity", "moving_objects:=true"));
  EXPECT_EQ(still.count(), 0u);
}

TEST_F(Scenarios, disparity_sleeps_while_nobody_listens_and_starts_anew) {
  setParam("Disparity", "odom_frame", "world_of_others");
  load("Disparity");
  EXPECT_TRUE(says("Disparity", "asleep"));
  tf2_ros::TransformBroadcaster broadcaster;
  for (const int first : {0, 2}) {
    DisparityRecorder disparity(node_, "disparity"), predicted(node_, "predicted_disparity");
    ASSERT_TRUE(player_.waitForSubscribers());
    ASSERT_TRUE(publishesDisparity(moved(first, "sleepy_camera", broadcaster), disparity));
    ASSERT_TRUE(publishesDisparity(moved(first + 1, "sleepy_camera", broadcaster), disparity));
    EXPECT_EQ(validPixels(*predicted.at(street().stamp(first))), 0u);
    EXPECT_GT(validPixels(*predicted.at(street().stamp(first + 1))), 0u);
    disparity.stop();
    predicted.stop();
    EXPECT_TRUE(eventually([&] { return player_.subscribers() == 0; }, 10));
  }
}

TEST_F(Scenarios, nothing_is_copied_between_nodelets_of_one_manager) {
  load("EgoMotion");
  load("Disparity");
  load("MovingObjects");
  StaticTransform extrinsic(street().extrinsic());
  // Each topic has two subscribers: all subscribers of a process must get the same message.
  DisparityRecorder disparity(node_, "disparity"), measured(node_, "measured_disparity"),
      measured_again(node_, "measured_disparity");
  Recorder<sensor_msgs::Image> inner(node_, "disparity/image"), left(node_, "left/image_rect"),
      mask(node_, "moving_objects/mask"), variance(node_, "measured_variance"),
      variance_again(node_, "measured_variance");
  Recorder<MovingObjectArray> objects(node_, "moving_objects");
  ASSERT_TRUE(player_.waitForSubscribers());
  for (int i = 0; i < 3; ++i) {
    const StereoPair pair = street().pair(i);
    const ros::Time stamp = pair.left->header.stamp;
    player_.publish(pair);
    ASSERT_TRUE(eventually([&] {
      return objects.at(stamp) && inner.at(stamp) && disparity.at(stamp) && measured.at(stamp) &&
             measured_again.at(stamp) && left.at(stamp) && variance.at(stamp) &&
             variance_again.at(stamp);
    })) << "frame "
        << i;
    EXPECT_EQ(left.at(stamp)->data.data(), pair.left->data.data());
    EXPECT_EQ(measured.at(stamp)->image.data.data(), measured_again.at(stamp)->image.data.data());
    EXPECT_EQ(variance.at(stamp)->data.data(), variance_again.at(stamp)->data.data());
    EXPECT_EQ(inner.at(stamp)->data.data(), disparity.at(stamp)->image.data.data());
  }
  // Our image topics do not use sockets.
  std::string host;
  uint32_t port = 0;
  ASSERT_TRUE(ros::network::splitURI(ros::XMLRPCManager::instance()->getServerURI(), host, port));
  XmlRpc::XmlRpcClient self(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller, answer;
  caller[0] = ros::this_node::getName();
  ASSERT_TRUE(self.execute("getBusInfo", caller, answer));
  XmlRpc::XmlRpcValue connections = answer[2];
  int within = 0;
  for (int i = 0; i < connections.size(); ++i) {
    const std::string transport = connections[i][3];
    const std::string topic = connections[i][4];
    if (topic.rfind(ns_ + "/", 0) != 0) continue;
    EXPECT_EQ(transport, "INTRAPROCESS") << topic;
    ++within;
  }
  EXPECT_GT(within, 10);
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "scenarios_test");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
