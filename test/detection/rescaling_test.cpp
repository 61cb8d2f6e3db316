/// Images of all sizes come to about one size, with the same points in space.
#include "detection/rescaling.h"

#include <gtest/gtest.h>

#include <utility>

namespace predictive_stereo {
namespace {

StereoRig rigOf(cv::Size size) {
  StereoRig rig;
  rig.size = size;
  rig.fx_px = 0.6 * size.width;
  rig.fy_px = rig.fx_px + 1;
  rig.cx_left_px = 0.5 * size.width - 7;
  rig.cx_right_px = rig.cx_left_px + 3;
  rig.cy_px = 0.5 * size.height + 4;
  rig.baseline_m = 0.12;
  return rig;
}

cv::Size rescaled(cv::Size size) { return Rescaling(rigOf(size)).of(rigOf(size)).size; }

TEST(Rescaling, LeavesCommonSizes) {
  for (const cv::Size size : {cv::Size(1242, 375), {640, 480}, {752, 480}, {848, 480}, {1024, 768}})
    EXPECT_EQ(rescaled(size), size);
  EXPECT_TRUE(Rescaling().isNone());
  EXPECT_EQ(Rescaling().cameraPixel_px(), 1);
}

TEST(Rescaling, EnlargesUpToTwiceAndReducesAny) {
  EXPECT_EQ(rescaled({320, 240}), cv::Size(640, 480));
  EXPECT_EQ(rescaled({8, 6}), cv::Size(16, 12));
  for (const cv::Size size :
       {cv::Size(640, 400), {994, 300}, {1280, 720}, {1920, 1080}, {4096, 3000}}) {
    const cv::Size result = rescaled(size);
    EXPECT_NEAR(result.area(), 1242 * 375, 2000) << size;
    EXPECT_NEAR(double(result.width) / result.height, double(size.width) / size.height, 0.01);
  }
}

// A part of a large image has its objects' size.
TEST(Rescaling, LeavesNarrowViews) {
  StereoRig rig = rigOf({320, 240});
  rig.fx_px = 600;
  EXPECT_EQ(Rescaling(rig).of(rig).size, cv::Size(480, 360));
  rig.fx_px = 900;
  EXPECT_TRUE(Rescaling(rig).isNone());
  EXPECT_TRUE(Rescaling(rig).isOf(rig));
  rig.fx_px = 600;
  EXPECT_FALSE(Rescaling(rigOf(rig.size)).isOf(rig));
}

// A pixel's centre stays where it is in space.
TEST(Rescaling, KeepsPointsInSpace) {
  for (const cv::Size size : {cv::Size(320, 200), {1920, 1080}}) {
    const StereoRig rig = rigOf(size), other = Rescaling(rigOf(size)).of(rig);
    const double sx = double(other.size.width) / size.width,
                 sy = double(other.size.height) / size.height;
    const Eigen::Vector3d point_m = rig.pointFromDisparity(20, 30, 12.5);
    const Eigen::Vector3d seen = other.disparityFromPoint(point_m);
    EXPECT_NEAR(seen.x(), sx * 20.5 - 0.5, 1e-9);
    EXPECT_NEAR(seen.y(), sy * 30.5 - 0.5, 1e-9);
    EXPECT_NEAR(seen.z(), sx * 12.5, 1e-9);
    EXPECT_NEAR(other.principalOffset(), sx * rig.principalOffset(), 1e-9);
  }
}

DetectionInput inputOf(cv::Size size, const DisparityRange& range) {
  DetectionInput input;
  input.rig = rigOf(size);
  input.left = cv::Mat1b(size, uchar{90});
  input.measured_disparity_px = cv::Mat1f(size, 20.0f);
  input.measured_variance_px2 = cv::Mat1f(size, 0.25f);
  input.measured_disparity_px(0, 1) = range.invalid();
  input.stamp_s = 3.5;
  input.pose_state = PoseState::kKnown;
  return input;
}

TEST(Rescaling, DisparitiesAndSigmasGrowWithTheImage) {
  const DisparityRange range;
  const cv::Size size(100, 80);
  const DetectionInput input = inputOf(size, range);
  DetectionInput enlarged;
  Rescaling(rigOf(size)).rescale(input, range, enlarged);
  EXPECT_EQ(enlarged.left.size(), cv::Size(200, 160));
  EXPECT_EQ(Rescaling(rigOf(size)).cameraPixel_px(), 2);
  EXPECT_EQ(enlarged.rig, Rescaling(rigOf(size)).of(input.rig));
  EXPECT_EQ(enlarged.stamp_s, input.stamp_s);
  EXPECT_EQ(enlarged.pose_state, input.pose_state);
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 200; ++x) {
      const bool is_known = y / 2 != 0 || x / 2 != 1;
      EXPECT_EQ(enlarged.measured_disparity_px(y, x), is_known ? 40 : range.invalid());
      EXPECT_EQ(enlarged.measured_variance_px2(y, x), 1);
      EXPECT_EQ(enlarged.left(y, x), 90);
    }
}

// Also where the range does not begin at 0; what is behind infinity stays known.
TEST(Rescaling, KeepsDepths) {
  const std::pair<int, float> cases[] = {{-8, -7.5f}, {-8, 30}, {20, 20}, {20, 22.5f}, {0, 0}};
  for (const cv::Size size : {cv::Size(100, 80), {1800, 1200}})
    for (const auto& [first, disparity_px] : cases) {
      const DisparityRange range{first, 64};
      DetectionInput input = inputOf(size, range), rescaled;
      input.measured_disparity_px.setTo(disparity_px);
      input.measured_disparity_px(cv::Rect(0, 0, 4, 4)) = range.invalid();
      Rescaling rescaling(rigOf(size));
      rescaling.rescale(input, range, rescaled);
      const DisparityRange other = rescaling.of(range);
      const float found = rescaled.measured_disparity_px(50, 50);
      EXPECT_FLOAT_EQ(found, rescaling.cameraPixel_px() * disparity_px);
      EXPECT_TRUE(other.isValid(found)) << found;
      EXPECT_EQ(rescaled.measured_disparity_px(0, 0), other.invalid());
      EXPECT_FALSE(other.isValid(other.invalid()));
    }
}

// A bright half of the image stays where it is.
TEST(Rescaling, KeepsEdges) {
  for (const cv::Size size : {cv::Size(100, 80), {1280, 720}, {1920, 1080}, {4096, 3000}}) {
    const DisparityRange range;
    DetectionInput input = inputOf(size, range), rescaled;
    input.left.colRange(size.width / 2, size.width).setTo(190);
    Rescaling(rigOf(size)).rescale(input, range, rescaled);
    const int middle = rescaled.left.cols / 2;
    const cv::Mat1b row = rescaled.left.row(rescaled.left.rows / 2);
    for (int x = 0; x < middle - 3; ++x) EXPECT_NEAR(row(x), 90, 1) << size << x;
    for (int x = middle + 4; x < row.cols; ++x) EXPECT_NEAR(row(x), 190, 1) << size << x;
    EXPECT_NEAR(cv::mean(row)[0], 140, 1) << size;
  }
}

// Into the mask's memory: it may be that of a message.
TEST(Rescaling, RestoresBoxesAndMask) {
  const cv::Size size(100, 80);
  Detections enlarged, detections;
  enlarged.objects.resize(1);
  enlarged.objects[0].box_px = {20, 40, 60, 30};
  enlarged.mask = cv::Mat1b(160, 200, uchar{0});
  enlarged.mask(cv::Rect(20, 40, 60, 30)).setTo(255);
  cv::Mat1b of_message(size, uchar{7});
  detections.mask = of_message;
  Rescaling(rigOf(size)).restore(enlarged, detections);
  ASSERT_EQ(detections.objects.size(), 1u);
  EXPECT_EQ(detections.objects[0].box_px, cv::Rect2f(10, 20, 30, 15));
  cv::Mat1b expected(size, uchar{0});
  expected(cv::Rect(10, 20, 30, 15)).setTo(255);
  EXPECT_EQ(cv::countNonZero(of_message != expected), 0);
}

}  // namespace
}  // namespace predictive_stereo
