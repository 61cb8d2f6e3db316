#include "evaluation/lidar_truth.h"

#include <gtest/gtest.h>

#include "evaluation/disparity_metrics.h"
#include "evaluation/sequence.h"
#include "tools/kitti_fixture.h"

namespace predictive_stereo {
namespace {

StereoRig rig() {
  StereoRig rig;
  rig.size = {64, 32};
  rig.fx_px = rig.fy_px = 100;
  rig.cx_left_px = rig.cx_right_px = 32;
  rig.cy_px = 16;
  rig.baseline_m = 0.5;
  return rig;
}

/// The point in camera coordinates at (x, y) with a disparity.
LidarPoint point(double x_px, double y_px, double disparity_px) {
  const Eigen::Vector3f p = rig().pointFromDisparity(x_px, y_px, disparity_px).cast<float>();
  return {p.x(), p.y(), p.z(), 0.5f};
}

cv::Mat1f truth(const std::vector<LidarPoint>& points) {
  return lidarTruth(visibleLidarPoints(points, Eigen::Isometry3d::Identity(), rig()), rig().size);
}

int known(const cv::Mat1f& truth_px) { return cv::countNonZero(truth_px != kNoTruth); }

TEST(LidarTruth, RoundsToPixelsAndKeepsTheNearest) {
  const cv::Mat1f map = truth({point(10.4, 5.4, 7), point(9.6, 4.6, 7.5), point(40, 20, 3)});
  EXPECT_NEAR(map(5, 10), 7.5, 1e-4);
  EXPECT_NEAR(map(20, 40), 3, 1e-4);
  EXPECT_EQ(known(map), 2);
}

TEST(LidarTruth, DropsWhatTheCameraCannotSee) {
  // A near surface occludes points behind it within 9 columns and 5 rows, but not beyond.
  const cv::Mat1f map = truth({point(30, 10, 20), point(39, 15, 4), point(40, 10, 4),
                               point(30, 16, 4), point(21, 5, 17.7)});
  EXPECT_EQ(map(15, 39), kNoTruth);
  EXPECT_NEAR(map(10, 40), 4, 1e-4);
  EXPECT_NEAR(map(16, 30), 4, 1e-4);
  EXPECT_NEAR(map(5, 21), 17.7, 1e-4);  // 20 < 1.05 * 17.7 + 1.5: the same surface
}

TEST(LidarTruth, IgnoresWhatIsNearerThanAMetreOrOutside) {
  EXPECT_EQ(known(truth({{0, 0, 1.0f, 0}, {0, 0, -5, 0}, {100, 0, 5, 0}})), 0);
}

TEST(LidarTruth, UsesTheScannersPose) {
  const KittiFixture files(1);
  // T of the fixture is (0, -0.1, -0.3): 10 m ahead of the camera, on its axis.
  files.write(KittiFixture::data("velodyne_points/data/0000000000.bin"),
              scanBytes({10.3f, 0, -0.1f, 1, -1e9f, 0, 0, 1}));
  const cv::Mat1f map = lidarTruth(KittiDrive(files.path(), KittiFixture::kDrive), 0);
  EXPECT_NEAR(map(16, 32), 5, 1e-3);
  EXPECT_EQ(known(map), 1);
}

TEST(KittiScene2012, ReadsPairsAndTruth) {
  const TemporaryDirectory files;
  const cv::Size size(64, 32);
  for (const char* folder : {"image_0", "image_1", "disp_occ", "disp_noc"})
    std::filesystem::create_directories(files.path(folder));
  for (int number : {5, 8, 9, 10, 11})  // without 7, 5 is not usable
    for (int camera : {0, 1})
      cv::imwrite(files.path("image_" + std::to_string(camera) + "/000027_" +
                             (number < 10 ? "0" : "") + std::to_string(number) + ".png"),
                  cv::Mat1b(size, static_cast<uchar>(10 * number + camera)));
  cv::Mat1w coded = cv::Mat1w::zeros(size);
  coded(3, 4) = 256 * 17 + 128;
  cv::imwrite(files.path("disp_occ/000027_10.png"), coded);
  files.write("calib/000027.txt",
              "P0: 100 0 32 0 0 100 16 0 0 0 1 0\nP1: 100 0 32 -50 0 100 16 0 0 0 1 0\n");
  EXPECT_EQ(listKittiScenes(KittiStereo::k2012, files.path()), std::vector<std::string>{"000027"});
  const auto scene = kittiScene(KittiStereo::k2012, files.path(), "000027");
  ASSERT_EQ(scene->frames(), 3);
  EXPECT_EQ(scene->frame(0).left(0, 0), 80);
  EXPECT_TRUE(scene->frame(0).truth_px.empty());
  EXPECT_EQ(scene->frame(2).right(0, 0), 101);
  const cv::Mat1f truth_px = scene->frame(2).truth_px;
  EXPECT_FLOAT_EQ(truth_px(3, 4), 17.5f);
  EXPECT_EQ(known(truth_px), 1);
  EXPECT_THROW(kittiScene(KittiStereo::k2012, files.path(), "000028"), std::runtime_error);
}

}  // namespace
}  // namespace predictive_stereo
