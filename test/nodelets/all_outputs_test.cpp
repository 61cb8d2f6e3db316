/// Plays a few frames of the synthetic street to the nodelets of the launch file, in a manager or
/// as nodes, and expects every output.
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <predictive_stereo/RowAlignment.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_srvs/Empty.h>
#include <stereo_msgs/DisparityImage.h>
#include <visualization_msgs/MarkerArray.h>

#include <cmath>
#include <cstring>

#include "recorder.h"
#include "stereo_player.h"
#include "street_camera.h"

namespace predictive_stereo {
namespace {

float floatAt(const sensor_msgs::Image& image, size_t pixel) {
  float value;
  std::memcpy(&value, &image.data[pixel * sizeof(float)], sizeof(value));
  return value;
}

void expectImage(const sensor_msgs::ImageConstPtr& image, const char* encoding) {
  ASSERT_TRUE(image);
  EXPECT_EQ(image->header.frame_id, StreetCamera::kFrame);
  EXPECT_EQ(image->encoding, encoding);
  EXPECT_EQ(image->width, static_cast<unsigned>(StreetCamera::kWidth));
  EXPECT_EQ(image->height, static_cast<unsigned>(StreetCamera::kHeight));
  EXPECT_EQ(image->data.size(), static_cast<size_t>(image->step) * image->height);
}

void expectDisparity(const stereo_msgs::DisparityImageConstPtr& disparity, const StereoRig& rig) {
  ASSERT_TRUE(disparity);
  EXPECT_EQ(disparity->header.frame_id, StreetCamera::kFrame);
  EXPECT_EQ(disparity->image.encoding, "32FC1");
  EXPECT_EQ(disparity->image.header.stamp, disparity->header.stamp);
  EXPECT_FLOAT_EQ(disparity->f, static_cast<float>(rig.fx_px));
  EXPECT_FLOAT_EQ(disparity->T, static_cast<float>(rig.baseline_m));
  EXPECT_EQ(disparity->min_disparity, 0);
  EXPECT_EQ(disparity->max_disparity, 127);
  EXPECT_GT(disparity->delta_d, 0);
  EXPECT_EQ(disparity->valid_window.width, static_cast<unsigned>(StreetCamera::kWidth));
  for (size_t i = 0; i < StreetCamera::kWidth * StreetCamera::kHeight; ++i) {
    const float d = floatAt(disparity->image, i);
    ASSERT_TRUE(d == -1 || (d >= 0 && d <= 128)) << "pixel " << i << ": " << d;
  }
}

TEST(AllOutputs, come_for_every_frame) {
  ros::NodeHandle camera("stereo");
  const StreetCamera street(6);
  StaticTransform extrinsic(street.extrinsic());

  Recorder<nav_msgs::Odometry> odometry(camera, "odometry");
  Recorder<geometry_msgs::PoseWithCovarianceStamped> pose(camera, "odometry/pose");
  Recorder<stereo_msgs::DisparityImage> disparity(camera, "disparity"),
      measured(camera, "measured_disparity"), predicted(camera, "predicted_disparity");
  Recorder<sensor_msgs::Image> variance(camera, "disparity_variance"),
      measured_variance(camera, "measured_variance"),
      predicted_variance(camera, "predicted_variance"), inner(camera, "disparity/image"),
      colour(camera, "disparity/color"), deviation(camera, "disparity/standard_deviation"),
      search_range(camera, "search_range"), depth(camera, "depth/image_rect"),
      mask(camera, "moving_objects/mask"), residual(camera, "moving_objects/residual"),
      overlay(camera, "moving_objects/image");
  Recorder<sensor_msgs::CameraInfo> depth_info(camera, "depth/camera_info");
  Recorder<sensor_msgs::PointCloud2> cloud(camera, "points2");
  Recorder<RowAlignment> row_alignment(camera, "row_alignment"),
      ego_alignment(camera, "odometry/row_alignment");
  Recorder<MovingObjectArray> objects(camera, "moving_objects");
  std::vector<visualization_msgs::MarkerArrayConstPtr> marker_arrays;
  const ros::Subscriber markers = camera.subscribe<visualization_msgs::MarkerArray>(
      "moving_objects/markers", 10, [&](const visualization_msgs::MarkerArrayConstPtr& array) {
        marker_arrays.push_back(array);
      });
  DiagnosticsRecorder diagnostics(camera);

  StereoPlayer player(camera);
  for (const char* name : {"ego_motion", "disparity", "moving_objects"})
    ASSERT_TRUE(ros::service::waitForService(camera.resolveName(name) + "/reset", 30000)) << name;
  ASSERT_TRUE(player.waitForSubscribers());
  ASSERT_TRUE(eventually([&] {
    return odometry.connected() && pose.connected() && disparity.connected() &&
           measured.connected() && predicted.connected() && variance.connected() &&
           measured_variance.connected() && predicted_variance.connected() && inner.connected() &&
           colour.connected() && deviation.connected() && search_range.connected() &&
           depth.connected() && depth_info.connected() && cloud.connected() &&
           row_alignment.connected() && ego_alignment.connected() && objects.connected() &&
           mask.connected() && residual.connected() && overlay.connected() &&
           markers.getNumPublishers() > 0;
  }));
  ros::Duration(1.0).sleep();  // until all are connected in both directions

  for (int i = 0; i < street.frames(); ++i) {
    const ros::Time stamp = street.stamp(i);
    player.publish(street.pair(i));
    const auto missing = [&] {
      std::string names;
      const auto ask = [&](const char* name, const auto& recorder) {
        if (!recorder.at(stamp)) names += std::string(" ") + name;
      };
      ask("odometry", odometry);
      ask("odometry/pose", pose);
      ask("odometry/row_alignment", ego_alignment);
      ask("disparity", disparity);
      ask("measured_disparity", measured);
      ask("predicted_disparity", predicted);
      ask("disparity_variance", variance);
      ask("measured_variance", measured_variance);
      ask("predicted_variance", predicted_variance);
      ask("disparity/image", inner);
      ask("disparity/color", colour);
      ask("disparity/standard_deviation", deviation);
      ask("search_range", search_range);
      ask("depth/image_rect", depth);
      ask("depth/camera_info", depth_info);
      ask("points2", cloud);
      ask("row_alignment", row_alignment);
      ask("moving_objects", objects);
      ask("moving_objects/mask", mask);
      ask("moving_objects/residual", residual);
      ask("moving_objects/image", overlay);
      return names;
    };
    ASSERT_TRUE(eventually([&] { return missing().empty(); }, 10)) << "frame " << i << missing();
    expectDisparity(disparity.at(stamp), street.rig());
    expectDisparity(measured.at(stamp), street.rig());
    expectDisparity(predicted.at(stamp), street.rig());
    expectImage(variance.at(stamp), "32FC1");
    expectImage(measured_variance.at(stamp), "32FC1");
    expectImage(predicted_variance.at(stamp), "32FC1");
    expectImage(inner.at(stamp), "32FC1");
    expectImage(colour.at(stamp), "bgr8");
    expectImage(deviation.at(stamp), "32FC1");
    expectImage(search_range.at(stamp), "16UC1");
    expectImage(depth.at(stamp), "32FC1");
    expectImage(mask.at(stamp), "mono8");
    expectImage(residual.at(stamp), "32FC1");
    expectImage(overlay.at(stamp), "bgr8");
    EXPECT_EQ(odometry.at(stamp)->header.frame_id, "odom");
    EXPECT_EQ(odometry.at(stamp)->child_frame_id, "base_link");
    EXPECT_EQ(objects.at(stamp)->header.frame_id, StreetCamera::kFrame);
    EXPECT_EQ(row_alignment.at(stamp)->header.frame_id, StreetCamera::kFrame);
  }
  EXPECT_TRUE(eventually([&] { return marker_arrays.size() == 6u; }));
  ASSERT_FALSE(marker_arrays.empty());
  EXPECT_EQ(marker_arrays[0]->markers.at(0).action, visualization_msgs::Marker::DELETEALL);

  // The same disparity in all representations.
  const ros::Time last = street.stamp(5);
  const auto map = disparity.at(last);
  const auto depths = depth.at(last);
  const auto points = cloud.at(last);
  EXPECT_EQ(inner.at(last)->data, map->image.data);
  ASSERT_EQ(points->width * points->height, map->image.width * map->image.height);
  size_t valid = 0, predicted_pixels = 0;
  for (size_t i = 0; i < StreetCamera::kWidth * StreetCamera::kHeight; ++i) {
    const float d = floatAt(map->image, i);
    float z;
    std::memcpy(&z, &points->data[i * points->point_step + 8], sizeof(z));
    if (d > 0) {
      ++valid;
      EXPECT_FLOAT_EQ(floatAt(*depths, i), map->f * map->T / d);
      EXPECT_NEAR(z, map->f * map->T / d, 1e-4 * z);
      EXPECT_GT(floatAt(*variance.at(last), i), 0);
    } else if (d < 0) {
      EXPECT_TRUE(std::isnan(floatAt(*depths, i)));
      EXPECT_TRUE(std::isnan(z));
      EXPECT_EQ(floatAt(*variance.at(last), i), 0);
    }
    predicted_pixels += floatAt(predicted.at(last)->image, i) >= 0;
  }
  const size_t pixels = StreetCamera::kWidth * StreetCamera::kHeight;
  EXPECT_GT(valid, 7 * pixels / 10);
  EXPECT_GT(predicted_pixels, pixels / 2) << "tf did not reach the Disparity nodelet";

  // The pose is the true one relative to the first frame.
  const Eigen::Isometry3d truth = street.T_world_base(0).inverse() * street.T_world_base(5);
  const auto& position = odometry.at(last)->pose.pose.position;
  EXPECT_LT((Eigen::Vector3d(position.x, position.y, position.z) - truth.translation()).norm(),
            0.05 * truth.translation().norm() + 0.02);

  EXPECT_TRUE(eventually([&] {
    return diagnostics.value("EgoMotion", "frames") == "6" &&
           diagnostics.value("Disparity", "frames") == "6" &&
           diagnostics.value("MovingObjects", "frames") == "6";
  }));
  EXPECT_NE(diagnostics.value("Disparity", "matching [ms]"), "");
  EXPECT_NE(diagnostics.value("Disparity", "SIMD target"), "");
  const StereoRig rig = stereoRig(street.pair(0));
  EXPECT_NEAR(std::stod(diagnostics.value("Disparity", "least depth [m]")),
              rig.fx_px * rig.baseline_m / 127, 0.01);
  EXPECT_NE(diagnostics.value("EgoMotion", "inliers"), "");

  // After a reset the next frame is the first one.
  for (const char* name : {"ego_motion", "disparity", "moving_objects"}) {
    std_srvs::Empty empty;
    EXPECT_TRUE(ros::service::call(camera.resolveName(name) + "/reset", empty)) << name;
  }
  odometry.clear();
  StereoPair again = street.pair(1);
  player.publish(again);
  ASSERT_TRUE(eventually([&] { return odometry.count() == 1; }));
  EXPECT_EQ(odometry.last()->pose.pose.position.x, 0);
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "all_outputs_test");
  ros::AsyncSpinner spinner(1);
  spinner.start();
  return RUN_ALL_TESTS();
}
