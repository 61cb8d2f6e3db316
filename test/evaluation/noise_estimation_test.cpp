#include "evaluation/noise_estimation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tools/kitti_fixture.h"

namespace predictive_stereo {
namespace {

TEST(ErrorHistogram, KnowsANormalDistribution) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0.1, 0.5);
  ErrorHistogram errors;
  for (int i = 0; i < 100000; ++i) errors.add(normal(random));
  for (int i = 0; i < 1000; ++i) errors.add(7);
  EXPECT_NEAR(errors.mean_px(), 0.1, 0.01);
  EXPECT_NEAR(errors.variance_px2(), 0.25, 0.005);
  // 1 % of the errors are 6.9 px from the mean of the others.
  EXPECT_NEAR(errors.varianceOfAll_px2(), 0.25 + 6.9 * 6.9 * (0.01 - 0.0001) * 100.0 / 101, 0.02);
  EXPECT_NEAR(errors.robustSigma_px(), 0.5, 0.01);
  EXPECT_NEAR(errors.grossShare(), 1000.0 / 101000, 1e-6);
  EXPECT_NEAR(errors.shareWithin(1.1), 0.9772 - 0.0082, 0.01);
}

TEST(ErrorImage, AddsUpErrorsOfCells) {
  ErrorImage errors({12, 8});
  errors.add(1, 1, 0.5);
  errors.add(2.4, 0, -1.0);  // in the same cell
  errors.add(9, 5, 0.75);
  errors.add(-1, 5, 9);  // outside
  errors.add(3, 8, 9);
  EXPECT_DOUBLE_EQ(errors.sum_px(0, 3), 1.5);
  EXPECT_DOUBLE_EQ(errors.sum_px(4, 0), 0);
  EXPECT_DOUBLE_EQ(errors.sum_px(11, 7), 0.75);
  const cv::Mat1w map = errors.map();
  ASSERT_EQ(map.size(), cv::Size(12, 8));
  EXPECT_EQ(map(0, 0), 65535);
  EXPECT_EQ(map(0, 4), 0);
  EXPECT_NEAR(map(7, 11), 32768, 1);
}

TEST(ErrorHistogram, WritesEveryStep) {
  ErrorHistogram errors;
  errors.add(-0.01);
  const std::string csv = errors.csv();
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 301);
  EXPECT_NE(csv.find("\n-0.01,1,1\n"), std::string::npos) << csv.substr(3000, 900);
}

TEST(ObjectLabels, MaskWhatMovesOrMayMove) {
  const TemporaryDirectory files;
  const std::string header =
      "frame,track,class,x1,y1,x2,y2,distance_m,truncated,occluded,motion,hard\n";
  const std::string path = files.write("a.csv", header +
                                                    "3,1,car,10,5,20,15,8.5,0,1,toward,0\n"
                                                    "3,2,ignore,30,5,35,15,,0,0,unknown,1\n"
                                                    "3,3,static,40,5,50,15,9,1,0,static,0\n"
                                                    "4,1,car,0,0,60,30,8,0,0,toward,0\r\n");
  const auto labels = readObjectLabels(path);
  ASSERT_EQ(labels.size(), 4u);
  EXPECT_EQ(labels[0].box_px, cv::Rect2d(10, 5, 10, 10));
  EXPECT_EQ(labels[0].distance_m, 8.5);
  EXPECT_FALSE(labels[1].distance_m);
  EXPECT_TRUE(labels[1].hard);
  const cv::Mat1b mask = movingMask(labels, 3, {60, 30}, 2);
  EXPECT_EQ(cv::countNonZero(mask), 14 * 14 + 9 * 14);
  EXPECT_EQ(mask(3, 8), 255);
  EXPECT_EQ(mask(10, 45), 0);

  files.write("a.csv", header + "3,1,car,ten,5,20,15,8.5,0,1,toward,0\n");
  EXPECT_NE(messageOf([&] { readObjectLabels(path); }).find("line 2"), std::string::npos);
  for (const std::string line :
       {"1e300,1,car,10,5,20,15", "3,1,car,-1e300,5,20,15", "3,1,car,10,5,1e10,15"}) {
    files.write("a.csv", header + line + ",8.5,0,1,toward,0\n");
    EXPECT_NE(messageOf([&] { readObjectLabels(path); }).find("is not a label"), std::string::npos)
        << line;
  }
  files.write("a.csv", "x,y\n");
  EXPECT_NE(messageOf([&] { readObjectLabels(path); }).find("first line"), std::string::npos);
}

/// LiDAR points of a ground plane 1.6 m below the camera.
std::vector<Eigen::Vector3d> groundPoints(const StereoRig& rig, const Eigen::Isometry3d& T_cam_prev,
                                          double phase) {
  std::vector<Eigen::Vector3d> points;
  for (int row = 190; row < 330; row += 4)
    for (int column = 20; column < 620; column += 3) {
      const double y = row + phase, x = column + phase;
      // The ground is fixed in the previous camera's frame: -y_prev + 1.6 = 0.
      const Eigen::Vector3d ray((x - rig.cx_left_px) / rig.fx_px, (y - rig.cy_px) / rig.fy_px, 1);
      const Eigen::Isometry3d T_prev_cam = T_cam_prev.inverse();
      const double depth_m = (1.6 - T_prev_cam.translation().y()) / (T_prev_cam.linear() * ray).y();
      if (depth_m > 0) points.push_back(rig.disparityFromPoint(depth_m * ray));
    }
  return points;
}

TEST(ProcessErrors, AreThoseOfTheEgoMotion) {
  StereoRig rig;
  rig.size = {640, 340};
  rig.fx_px = rig.fy_px = 600;
  rig.cx_left_px = rig.cx_right_px = 320;
  rig.cy_px = 160;
  rig.baseline_m = 0.5;
  Eigen::Isometry3d T_cam_prev = Eigen::Isometry3d::Identity();
  T_cam_prev.translation().z() = -0.8;
  T_cam_prev.linear() = Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const auto before = groundPoints(rig, Eigen::Isometry3d::Identity(), 0.0);
  const auto after = groundPoints(rig, T_cam_prev, 0.3);

  ErrorHistogram right, wrong, masked;
  ErrorImage image(rig.size), wrong_image(rig.size);
  addProcessErrors(before, after, rig, T_cam_prev, {}, right, image);
  EXPECT_GT(right.count(), 1000);
  EXPECT_LT(std::sqrt(right.variance_px2()), 0.02);  // the ground is flat in disparity space
  EXPECT_NEAR(right.mean_px(), 0, 0.01);

  // Too low by 5 cm: disparities of the ground are wrong by d * 0.05 / 1.6.
  Eigen::Isometry3d lifted = T_cam_prev;
  lifted.translation().y() -= 0.05;
  addProcessErrors(before, after, rig, lifted, {}, wrong, wrong_image);
  EXPECT_GT(std::abs(wrong.mean_px()), 0.2);
  EXPECT_GT(wrong_image.sum_px(320, 300), 10 * image.sum_px(320, 300));
  EXPECT_EQ(wrong_image.sum_px(320, 100), 0) << "there is no ground above the horizon";

  addProcessErrors(before, after, rig, T_cam_prev, cv::Mat1b(rig.size, uchar{255}), masked, image);
  EXPECT_EQ(masked.count(), 0);
}

}  // namespace
}  // namespace predictive_stereo
