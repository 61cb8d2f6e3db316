/// Two stereo cameras in one manager, with images of equal stamps, do not affect each other.
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <stereo_msgs/DisparityImage.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <set>

#include "nodelets/stereo_messages.h"
#include "recorder.h"
#include "stereo_player.h"
#include "street_camera.h"

namespace predictive_stereo {
namespace {

constexpr int kFrames = 6;

struct Camera {
  Camera(const std::string& camera, int seed)
      : name(camera), node("/" + camera), street(kFrames, seed), player(node) {}

  std::string frame() const { return name + "_camera"; }

  geometry_msgs::TransformStamped extrinsic() const {
    geometry_msgs::TransformStamped result = street.extrinsic();
    result.header.frame_id = name + "_base";
    result.child_frame_id = frame();
    return result;
  }
  void play(int index) {
    StereoPair pair = street.pair(index);
    const auto framed = [&](auto& message) {
      auto copy = boost::make_shared<std::decay_t<decltype(*message)>>(*message);
      copy->header.frame_id = frame();
      message = copy;
    };
    framed(pair.left);
    framed(pair.right);
    framed(pair.left_info);
    framed(pair.right_info);
    player.publish(pair);
  }

  std::string name;
  ros::NodeHandle node;
  StreetCamera street;
  StereoPlayer player;
  Recorder<nav_msgs::Odometry> odometry{node, "odometry"};
  Recorder<stereo_msgs::DisparityImage> disparity{node, "disparity"},
      predicted{node, "predicted_disparity"};
  Recorder<MovingObjectArray> objects{node, "moving_objects"};
};

/// Share of the pixels known in both that differ by less than a pixel.
double agreement(const stereo_msgs::DisparityImage& message, const cv::Mat1f& truth) {
  const cv::Mat1f map = floatView(message.image, "disparity");
  const cv::Mat known = (map > 0) & (truth > 0) & (truth < message.max_disparity);
  const cv::Mat close = known & (cv::abs(map - truth) < 1);
  return static_cast<double>(cv::countNonZero(close)) / std::max(1, cv::countNonZero(known));
}

TEST(TwoCameras, do_not_mix) {
  Camera front("front", 1), rear("rear", 5);
  const Recorder<tf2_msgs::TFMessage> tf(ros::NodeHandle(), "/tf");
  const StaticTransform front_mount(front.extrinsic()), rear_mount(rear.extrinsic());
  for (const Camera* camera : {&front, &rear}) {
    for (const char* nodelet : {"ego_motion", "disparity", "moving_objects"})
      ASSERT_TRUE(
          ros::service::waitForService("/" + camera->name + "/" + nodelet + "/reset", 60000));
    ASSERT_TRUE(camera->player.waitForSubscribers());
    ASSERT_TRUE(eventually([&] {
      return camera->odometry.connected() && camera->disparity.connected() &&
             camera->predicted.connected() && camera->objects.connected();
    }));
  }
  ros::WallDuration(2).sleep();  // until all are connected
  for (int i = 0; i < kFrames; ++i) {
    front.play(i);
    rear.play(i);
    for (const Camera* camera : {&front, &rear})
      ASSERT_TRUE(eventually([&] {
        const ros::Time stamp = camera->street.stamp(i);
        return camera->odometry.at(stamp) && camera->disparity.at(stamp) &&
               camera->predicted.at(stamp) && camera->objects.at(stamp);
      })) << camera->name
          << ", frame " << i;
  }

  const double itself = agreement(*front.disparity.last(), front.street.truth(5).disparity_px);
  EXPECT_GT(itself, 0.8);
  EXPECT_GT(agreement(*rear.disparity.last(), rear.street.truth(5).disparity_px), 0.8);
  EXPECT_LT(agreement(*front.disparity.last(), rear.street.truth(5).disparity_px), itself - 0.2)
      << "the two see the same";
  for (const Camera* camera : {&front, &rear}) {
    SCOPED_TRACE(camera->name);
    const auto odometry = camera->odometry.last();
    EXPECT_EQ(odometry->header.frame_id, camera->name + "_odom");
    EXPECT_EQ(odometry->child_frame_id, camera->name + "_base");
    const Eigen::Isometry3d truth =
        camera->street.T_world_base(0).inverse() * camera->street.T_world_base(5);
    const auto& position = odometry->pose.pose.position;
    EXPECT_LT((Eigen::Vector3d(position.x, position.y, position.z) - truth.translation()).norm(),
              0.05 * truth.translation().norm() + 0.02);
    EXPECT_EQ(camera->disparity.last()->header.frame_id, camera->frame());
    EXPECT_EQ(camera->objects.last()->header.frame_id, camera->frame());
    EXPECT_EQ(camera->disparity.last()->max_disparity, camera == &front ? 127 : 63);
    EXPECT_GT(agreement(*camera->predicted.last(), camera->street.truth(5).disparity_px), 0.7)
        << "the motion did not reach it";
  }
  std::set<std::pair<std::string, std::string>> moved;
  for (const auto& message : tf.messages())
    for (const auto& transform : message->transforms)
      moved.emplace(transform.header.frame_id, transform.child_frame_id);
  EXPECT_EQ(moved, (std::set<std::pair<std::string, std::string>>{{"front_odom", "front_base"},
                                                                  {"rear_odom", "rear_base"}}));
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "two_cameras_test");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
