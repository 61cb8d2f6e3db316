/// Runs the tool on small drives, and reads its bags.
#include <gtest/gtest.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2/buffer_core.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

#include <map>

#include "tools/bag_messages.h"
#include "tools/kitti_drive.h"
#include "tools/tool_fixture.h"

namespace predictive_stereo {
namespace {

void addOxtsAndLidar(const KittiFixture& files) {
  for (int i = 0; i < files.frames(); ++i) {
    const std::string number = "000000000" + std::to_string(i);
    files.write(KittiFixture::data("oxts/data/" + number + ".txt"),
                oxtsText(0.1 * i, 8 + 1e-5 * i));
    files.write(KittiFixture::data("velodyne_points/data/" + number + ".bin"),
                scanBytes({1, 2, 3, 0.5f, 4, 5, 6, 0.25f}));
  }
}

std::map<std::string, int> countTopics(const std::string& path) {
  const rosbag::Bag bag(path);
  std::map<std::string, int> counts;
  for (const rosbag::MessageInstance& message : rosbag::View(bag)) ++counts[message.getTopic()];
  return counts;
}

template <class Message>
typename Message::ConstPtr firstOf(const std::string& bag, const std::string& topic) {
  return messagesIn<Message>(bag).at(topic)[0];
}

/// All transforms of the bag.
void fill(const std::string& bag, tf2::BufferCore& buffer) {
  for (const auto& [topic, messages] : messagesIn<tf2_msgs::TFMessage>(bag))
    for (const auto& message : messages)
      for (const auto& transform : message->transforms)
        buffer.setTransform(transform, "bag", topic == "/tf_static");
}

Eigen::Isometry3d lookup(const tf2::BufferCore& buffer, const std::string& parent,
                         const std::string& child, int64_t stamp_ns) {
  ros::Time time;
  time.fromNSec(static_cast<uint64_t>(stamp_ns));
  return Eigen::Isometry3d(tf2::transformToEigen(buffer.lookupTransform(parent, child, time)));
}

class KittiToBag : public ToolTest {
 protected:
  Result convert(const KittiFixture& drive, const std::string& arguments) const {
    return run(std::string(KITTI_TO_BAG) + " " + drive.path() + " " + KittiFixture::kDrive + " " +
               arguments);
  }
  std::string bagOf(const KittiFixture& drive, const std::string& options = "") const {
    const Result result = convert(drive, files_.path("out.bag") + options);
    EXPECT_EQ(result.status, 0) << result.errors;
    return files_.path("out.bag");
  }
};

TEST_F(KittiToBag, HasTheLayoutOfKitti2bag) {
  const KittiFixture files(2);
  addOxtsAndLidar(files);
  const std::string bag = bagOf(files);
  const std::map<std::string, int> expected = {{"/kitti/camera_gray_left/image_raw", 2},
                                               {"/kitti/camera_gray_left/camera_info", 2},
                                               {"/kitti/camera_gray_right/image_raw", 2},
                                               {"/kitti/camera_gray_right/camera_info", 2},
                                               {"/kitti/oxts/imu", 2},
                                               {"/kitti/oxts/gps/fix", 2},
                                               {"/kitti/oxts/gps/vel", 2},
                                               {"/kitti/velo/pointcloud", 2},
                                               {"/tf", 2},
                                               {"/tf_static", 2}};
  EXPECT_EQ(countTopics(bag), expected);

  const auto image = firstOf<sensor_msgs::Image>(bag, "/kitti/camera_gray_right/image_raw");
  EXPECT_EQ(image->encoding, "mono8");
  EXPECT_EQ(image->header.frame_id, "camera_gray_right");
  EXPECT_EQ(image->header.stamp.toNSec() % 10000000000u, 500000001u);
  EXPECT_EQ(image->data[0], 1);
  const auto info = firstOf<sensor_msgs::CameraInfo>(bag, "/kitti/camera_gray_right/camera_info");
  EXPECT_EQ(info->width, 64u);
  EXPECT_EQ(info->K[0], 110);
  EXPECT_EQ(info->D.size(), 5u);
  EXPECT_EQ(info->P[3], -50);
  EXPECT_EQ(info->distortion_model, "plumb_bob");
  const auto cloud = firstOf<sensor_msgs::PointCloud2>(bag, "/kitti/velo/pointcloud");
  EXPECT_EQ(cloud->width, 2u);
  EXPECT_EQ(cloud->fields[3].name, "i");
  EXPECT_EQ(*reinterpret_cast<const float*>(&cloud->data[20]), 5.0f);
  EXPECT_EQ(firstOf<sensor_msgs::NavSatFix>(bag, "/kitti/oxts/gps/fix")->latitude, 49);
}

TEST_F(KittiToBag, TransformsGiveTheDrivesPoses) {
  const KittiFixture files(2);
  addOxtsAndLidar(files);
  const KittiDrive drive(files.path(), KittiFixture::kDrive);
  tf2::BufferCore buffer;
  fill(bagOf(files), buffer);
  const auto stamps = drive.stamps("oxts");
  for (size_t i = 0; i < 2; ++i)
    EXPECT_TRUE(
        lookup(buffer, "world", "camera_gray_left", stamps[i]).isApprox((*drive.poses())[i], 1e-9));
  EXPECT_TRUE(lookup(buffer, "camera_gray_left", "velo_link", stamps[0])
                  .isApprox(drive.T_cam_velo(), 1e-9));
  EXPECT_NEAR(lookup(buffer, "camera_gray_left", "camera_gray_right", stamps[0]).translation().x(),
              0.5, 1e-12);
}

TEST_F(KittiToBag, PosesWithoutOxtsStandUpright) {
  const KittiFixture files(2);
  files.write(KittiFixture::data("poses_gt_cam0.txt"),
              "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 2.5\n");
  std::filesystem::remove(files.path("calib_imu_to_velo.txt"));
  std::filesystem::remove(files.path("calib_velo_to_cam.txt"));
  const std::string bag = bagOf(files);
  EXPECT_EQ(countTopics(bag).count("/kitti/oxts/imu"), 0u);
  tf2::BufferCore buffer;
  fill(bag, buffer);
  const auto stamps = KittiDrive(files.path(), KittiFixture::kDrive).stamps("image_00");
  EXPECT_TRUE(lookup(buffer, "world", "base_link", stamps[1])
                  .translation()
                  .isApprox(Eigen::Vector3d(2.5, 0, 0), 1e-9));
  // A point ahead of the camera is ahead of the base, a point below it is below.
  const Eigen::Isometry3d T_base_cam = lookup(buffer, "base_link", "camera_gray_left", stamps[0]);
  EXPECT_TRUE((T_base_cam * Eigen::Vector3d(1, 2, 3)).isApprox(Eigen::Vector3d(3, -1, -2), 1e-9));
}

TEST_F(KittiToBag, ColourPairIsBgr) {
  const KittiFixture files(1);
  const std::string bag = bagOf(files, " --cameras color");
  const auto image = firstOf<sensor_msgs::Image>(bag, "/kitti/camera_color_left/image_raw");
  EXPECT_EQ(image->encoding, "bgr8");
  EXPECT_EQ(image->step, 3 * 64u);
  EXPECT_EQ(countTopics(bag).count("/tf"), 0u);  // no poses are known
}

TEST_F(KittiToBag, LeavesNothingAfterAnError) {
  const KittiFixture files(3);
  files.write(KittiFixture::data("image_01/data/0000000001.png"), "broken");
  std::filesystem::create_directory(files.path("out"));
  for (const auto& [name, part] : {std::pair("out/x.bag", "image_01/data/0000000001.png"),
                                   std::pair("no/x.bag", "no/x.bag: cannot be written")}) {
    const Result result = convert(files, files.path(name));
    EXPECT_EQ(result.status, 1);
    EXPECT_NE(result.errors.find(part), std::string::npos) << result.errors;
  }
  EXPECT_TRUE(std::filesystem::is_empty(files.path("out")));
}

}  // namespace
}  // namespace predictive_stereo
