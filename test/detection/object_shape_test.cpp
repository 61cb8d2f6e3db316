#include "detection/object_shape.h"

#include <gtest/gtest.h>

namespace predictive_stereo {
namespace {

StereoRig testRig() {
  StereoRig rig;
  rig.size = {400, 300};
  rig.fx_px = rig.fy_px = 500;
  rig.cx_left_px = rig.cx_right_px = 200;
  rig.cy_px = 150;
  rig.baseline_m = 0.5;
  return rig;
}

TEST(ObjectShape, OfAnUprightRectangle) {
  const StereoRig rig = testRig();
  const cv::Rect area(250, 100, 51, 81);
  cv::Mat1f disparity(rig.size, 5.0f);  // 50 m
  disparity(area) = 25.0f;              // 10 m
  disparity(cv::Rect(250, 100, 51, 2)) = -1.0f;
  const cv::Mat1b mask(area.size(), 255);
  const auto shape = shapeOf(rig, DisparityRange(), disparity, area, mask);
  ASSERT_TRUE(shape);
  EXPECT_NEAR(shape->distance_m, 10, 1e-6);
  EXPECT_NEAR(shape->centre_m.x(), 75.0 / 50, 0.03);
  EXPECT_NEAR(shape->centre_m.y(), -10.0 / 50, 0.05);
  EXPECT_NEAR(shape->centre_m.z(), 10, 1e-6);
  EXPECT_NEAR(shape->size_m.x(), 0.9, 0.06);
  EXPECT_NEAR(shape->size_m.y(), 0.9 * 78 / 50, 0.08);
  EXPECT_NEAR(shape->size_m.z(), 0, 1e-6);
}

TEST(ObjectShape, IgnoresWhatIsNotInTheMaskAndTails) {
  const StereoRig rig = testRig();
  const cv::Rect area(100, 100, 40, 40);
  cv::Mat1f disparity(rig.size, 20.0f);
  disparity(cv::Rect(120, 100, 20, 40)) = 60.0f;
  disparity(cv::Rect(100, 100, 20, 1)) = 90.0f;
  cv::Mat1b mask = cv::Mat1b::zeros(area.size());
  mask(cv::Rect(0, 0, 20, 40)) = 255;
  const auto shape = shapeOf(rig, DisparityRange(), disparity, area, mask);
  ASSERT_TRUE(shape);
  EXPECT_NEAR(shape->distance_m, 12.5, 1e-6);
}

TEST(ObjectShape, NeedsPoints) {
  const StereoRig rig = testRig();
  const cv::Mat1f nothing(rig.size, -1.0f);
  const cv::Rect area(100, 100, 40, 40);
  EXPECT_FALSE(shapeOf(rig, DisparityRange(), nothing, area, cv::Mat1b(area.size(), 255)));
}

}  // namespace
}  // namespace predictive_stereo
