/// Runs the tool and reads its bag.
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <sensor_msgs/CameraInfo.h>
#include <stereo_msgs/DisparityImage.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

#include <cstring>
#include <filesystem>

#include "bag_messages.h"
#include "evaluation/simulation/street.h"
#include "tool_fixture.h"

namespace predictive_stereo {
namespace {

class StreetToBag : public ToolTest {
 protected:
  int streetToBag(const std::string& arguments) const {
    return run(std::string(STREET_TO_BAG) + " " + arguments).status;
  }
  std::string path(const std::string& name) const { return files_.path(name); }
  size_t bags() const {
    size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(files_.path("")))
      count += entry.path().filename() != "stderr" && entry.path().filename() != "stdout";
    return count;
  }
};

TEST_F(StreetToBag, HoldsTheStreetAndItsTruth) {
  ASSERT_EQ(streetToBag(path("a.bag") + " --scene turn --frames 6 --size 320x96 --seed 4"), 0);
  EXPECT_EQ(bags(), 1u);
  StreetParams params;
  params.scene = "turn";
  params.frames = 6;
  params.width = 320;
  params.height = 96;
  params.seed = 4;
  const Street street(params);

  const auto images = messagesIn<sensor_msgs::Image>(path("a.bag"));
  const auto infos = messagesIn<sensor_msgs::CameraInfo>(path("a.bag"));
  const auto disparities = messagesIn<stereo_msgs::DisparityImage>(path("a.bag"));
  const auto odometry = messagesIn<nav_msgs::Odometry>(path("a.bag"));
  const auto objects = messagesIn<MovingObjectArray>(path("a.bag"));
  const auto transforms = messagesIn<tf2_msgs::TFMessage>(path("a.bag"));
  ASSERT_EQ(images.at("/street/left/image_rect").size(), 6u);
  ASSERT_EQ(images.at("/street/right/image_rect").size(), 6u);
  ASSERT_EQ(infos.at("/street/right/camera_info").size(), 6u);
  ASSERT_EQ(disparities.at("/street/truth/disparity").size(), 6u);
  ASSERT_EQ(odometry.at("/street/truth/odometry").size(), 6u);
  ASSERT_EQ(objects.at("/street/truth/moving_objects").size(), 6u);

  // base_link -> camera_link -> optical frame.
  const auto& chain = transforms.at("/tf_static").at(0)->transforms;
  ASSERT_EQ(chain.size(), 2u);
  EXPECT_EQ(chain[0].header.frame_id, "base_link");
  EXPECT_EQ(chain[0].child_frame_id, chain[1].header.frame_id);
  const Eigen::Isometry3d T_base_optical(tf2::transformToEigen(chain[0]).matrix() *
                                         tf2::transformToEigen(chain[1]).matrix());

  Matrix34d P_left, P_right;
  for (int i = 0; i < 12; ++i) {
    P_left(i / 4, i % 4) = infos.at("/street/left/camera_info")[0]->P[static_cast<size_t>(i)];
    P_right(i / 4, i % 4) = infos.at("/street/right/camera_info")[0]->P[static_cast<size_t>(i)];
  }
  const StereoRig rig = StereoRig::fromProjections(P_left, P_right, {320, 96});
  EXPECT_NEAR(rig.baseline_m, street.rig().baseline_m, 1e-9);
  EXPECT_EQ(rig.fx_px, street.rig().fx_px);

  const Eigen::Isometry3d T_world_odom = street.poseOf(0) * T_base_optical.inverse();
  for (int i = 0; i < 6; ++i) {
    const auto at = static_cast<size_t>(i);
    const StreetFrame frame = street.render(i);
    const auto& left = images.at("/street/left/image_rect")[at];
    EXPECT_EQ(left->encoding, "mono8");
    EXPECT_EQ(left->header.frame_id, chain[1].child_frame_id);
    EXPECT_NEAR(
        (left->header.stamp - images.at("/street/left/image_rect")[0]->header.stamp).toSec(),
        frame.stamp_s, 1e-6);
    EXPECT_EQ(left->header.stamp, images.at("/street/right/image_rect")[at]->header.stamp);
    EXPECT_EQ(std::memcmp(left->data.data(), frame.left.data, left->data.size()), 0);
    const auto& disparity = disparities.at("/street/truth/disparity")[at]->image;
    EXPECT_EQ(disparity.encoding, "32FC1");
    EXPECT_EQ(std::memcmp(disparity.data.data(), frame.disparity_px.data, disparity.data.size()),
              0);

    const auto& pose = odometry.at("/street/truth/odometry")[at];
    Eigen::Isometry3d T_odom_base;
    tf2::fromMsg(pose->pose.pose, T_odom_base);
    const Eigen::Isometry3d T_world_cam = T_world_odom * T_odom_base * T_base_optical;
    EXPECT_TRUE(T_world_cam.isApprox(frame.T_world_cam, 1e-9)) << "frame " << i;
    if (i > 0) {
      // The twist gives the motion to the next pose, except for its change in between.
      Eigen::Isometry3d T_odom_before;
      tf2::fromMsg(odometry.at("/street/truth/odometry")[at - 1]->pose.pose, T_odom_before);
      const double way_m = (T_odom_before.inverse() * T_odom_base).translation().x();
      EXPECT_NEAR(pose->twist.twist.linear.x, way_m / 0.1, 0.35) << "frame " << i;
    }

    const auto& listed = objects.at("/street/truth/moving_objects")[at]->objects;
    ASSERT_EQ(listed.size(), frame.movers.size());
    for (size_t k = 0; k < listed.size(); ++k) {
      const StreetMover& mover = frame.movers[k];
      EXPECT_EQ(listed[k].id, static_cast<uint32_t>(mover.id));
      EXPECT_EQ(listed[k].bbox.center.x - 0.5 * listed[k].bbox.size_x, mover.box_px.x);
      EXPECT_EQ(listed[k].score, mover.visibleShare());
      EXPECT_EQ(listed[k].bbox.size_y, mover.box_px.height);
      EXPECT_EQ(listed[k].pose.position.z, mover.centre_m.z());
      const Eigen::Vector3d velocity(listed[k].velocity.x, listed[k].velocity.y,
                                     listed[k].velocity.z);
      EXPECT_TRUE((T_world_odom.linear() * velocity).isApprox(mover.velocity_mps, 1e-9));
    }
  }
}

TEST_F(StreetToBag, SameOptionsGiveTheSameBag) {
  const std::string options = " --frames 2 --size 160x64 --namespace cam";
  ASSERT_EQ(streetToBag(path("a.bag") + options), 0);
  ASSERT_EQ(streetToBag(path("b.bag") + options + " --compress"), 0);
  const auto a = messagesIn<sensor_msgs::Image>(path("a.bag"));
  const auto b = messagesIn<sensor_msgs::Image>(path("b.bag"));
  ASSERT_EQ(a.at("/cam/left/image_rect").size(), 2u);
  for (size_t i = 0; i < 2; ++i)
    EXPECT_EQ(a.at("/cam/left/image_rect")[i]->data, b.at("/cam/left/image_rect")[i]->data);
}

TEST_F(StreetToBag, MistakesLeaveNothingBehind) {
  EXPECT_NE(streetToBag(path("a.bag") + " --scene moon"), 0);
  EXPECT_NE(streetToBag(path("a.bag") + " --frames 0"), 0);
  EXPECT_NE(streetToBag(path("a.bag") + " --size 8x8"), 0);
  EXPECT_NE(streetToBag(path("no/such/folder/a.bag") + " --frames 1"), 0);
  EXPECT_NE(streetToBag(path("a.bag") + " " + path("b.bag")), 0);
  EXPECT_NE(streetToBag(path("a.bag") + " --namespace my-camera"), 0);
  EXPECT_NE(streetToBag(""), 0);
  EXPECT_EQ(bags(), 0u);
  EXPECT_EQ(streetToBag("--help"), 0);
}

}  // namespace
}  // namespace predictive_stereo
