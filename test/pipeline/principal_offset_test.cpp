/// The same scene, seen by rigs whose right camera has another principal point: all that is
/// published is the same, for every pixel that both cameras see.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "odometry/corridor.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {
namespace {

constexpr int kFrames = 4;
constexpr double kStep_m = 0.3;
constexpr double kBorderPx = 5;  // census windows do not fit closer to a border

StereoRig rigWith(double principal_offset_px) {
  StereoRig rig;
  rig.size = {512, 224};
  rig.fx_px = rig.fy_px = 380;
  rig.cx_left_px = 255.5;
  rig.cx_right_px = rig.cx_left_px - principal_offset_px;
  rig.cy_px = 105.5;
  rig.baseline_m = 0.7;
  return rig;
}

Eigen::Isometry3d poseOf(int frame) {
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  T_world_cam.translation().z() = kStep_m * frame;
  return T_world_cam;
}

cv::Mat1f truthOf(const StereoRig& rig, int frame) {
  cv::Mat1f disparity_px(rig.size);
  const Eigen::Vector3d centre = poseOf(frame).translation();
  for (int y = 0; y < rig.size.height; ++y)
    for (int x = 0; x < rig.size.width; ++x) {
      const Eigen::Vector3d ray((x - rig.cx_left_px) / rig.fx_px, (y - rig.cy_px) / rig.fy_px, 1);
      const double depth_m = testing::Corridor::distance(centre, ray);
      disparity_px(y, x) = static_cast<float>(rig.disparityTimesDepth() / depth_m);
    }
  return disparity_px;
}

PipelineParams params() {
  PipelineParams params;
  params.disparity.matcher.range.count = 64;
  return params;
}

StereoFrame frameOf(const StereoRig& rig, int frame) {
  static const testing::Corridor corridor(1);
  const Eigen::Isometry3d T_world_cam = poseOf(frame);
  return {corridor.render(rig, T_world_cam, 0, 1.5, 2 * frame + 1),
          corridor.render(rig, T_world_cam, rig.baseline_m, 1.5, 2 * frame + 2), rig,
          frame * std::chrono::milliseconds(100)};
}

PipelineOutput lastOutput(const StereoRig& rig) {
  Pipeline pipeline(params());
  PipelineOutput output;
  for (int i = 0; i < kFrames; ++i) EXPECT_TRUE(pipeline.process(frameOf(rig, i), output));
  return output;
}

/// Of the pixels that both cameras of a rig see.
struct Comparison {
  int seen = 0, known = 0;     // all of them
  int compared = 0, lost = 0;  // known without an offset
  double difference_px = 0;    // mean, from the result without an offset
  double bias_px = 0;          // mean error
};

Comparison compare(const cv::Mat1f& disparity_px, const StereoRig& rig, const cv::Mat1f& plain_px,
                   const cv::Mat1f& truth_px) {
  Comparison result;
  for (int y = 0; y < rig.size.height; ++y)
    for (int x = 0; x < rig.size.width; ++x) {
      const double right_x = x - truth_px(y, x) - rig.principalOffset();
      if (right_x < kBorderPx || right_x > rig.size.width - 1 - kBorderPx) continue;
      const bool known = disparity_px(y, x) >= 0, was_known = plain_px(y, x) >= 0;
      ++result.seen;
      result.known += known;
      result.lost += was_known && !known;
      if (known) result.bias_px += disparity_px(y, x) - truth_px(y, x);
      if (!known || !was_known) continue;
      ++result.compared;
      result.difference_px += disparity_px(y, x) - plain_px(y, x);
    }
  result.difference_px /= std::max(result.compared, 1);
  result.bias_px /= std::max(result.known, 1);
  return result;
}

class PrincipalOffsets : public ::testing::TestWithParam<double> {
 protected:
  static void SetUpTestSuite() { plain_ = lastOutput(rigWith(0)); }
  static void TearDownTestSuite() { plain_ = PipelineOutput(); }

  static PipelineOutput plain_;
};

PipelineOutput PrincipalOffsets::plain_;

TEST_P(PrincipalOffsets, LoseNoPixelAndChangeNoDisparity) {
  const StereoRig rig = rigWith(GetParam());
  const cv::Mat1f truth_px = truthOf(rig, kFrames - 1);
  const PipelineOutput output = lastOutput(rig);
  const auto check = [&](const char* name, const cv::Mat1f& map_px, const cv::Mat1f& plain_px,
                         double lost_share) {
    SCOPED_TRACE(name);
    const Comparison c = compare(map_px, rig, plain_px, truth_px);
    EXPECT_GT(c.compared, 0.8 * c.seen);
    EXPECT_GT(c.known, 0.997 * c.seen);
    EXPECT_LE(c.lost, lost_share * c.compared);
    EXPECT_LT(std::abs(c.difference_px), 0.01);
    EXPECT_LT(std::abs(c.bias_px), 0.035);  // 0.026 without an offset
  };
  const DisparityOutput &maps = output.disparity, &plain = plain_.disparity;
  check("disparity", maps.disparity_px, plain.disparity_px, 0);
  check("measured", maps.measured_disparity_px, plain.measured_disparity_px, 0.002);
  check("predicted", maps.predicted_disparity_px, plain.predicted_disparity_px, 0.002);
}

TEST_P(PrincipalOffsets, LeaveTheMotionAndTheDetectionAsTheyAre) {
  const PipelineOutput output = lastOutput(rigWith(GetParam()));
  EXPECT_EQ(output.ego_motion.state, PoseState::kKnown);
  const Eigen::Vector3d path_m = output.pose.T_odom_cam.translation();
  EXPECT_LT((path_m - Eigen::Vector3d(0, 0, kStep_m * (kFrames - 1))).norm(), 0.03);
  EXPECT_EQ(output.column_offset.correction_px, 0);
  EXPECT_TRUE(output.detections.objects.empty());
}

INSTANTIATE_TEST_SUITE_P(Px, PrincipalOffsets,
                         ::testing::Values(-200.0, -101.7, -37.4, 0.0, 0.5, 12.25, 101.7, 200.0));

// Swapped images have disparities of the other sign. Offsets of some -40 px are left out: there the
// scene's disparities of swapped images are disparities of the range, too.
TEST(PrincipalOffset, SwappedImagesAreTold) {
  for (const double offset_px : {-200.0, -101.7, 0.0, 12.25, 101.7, 200.0}) {
    const StereoRig rig = rigWith(offset_px);
    const StereoFrame frame = frameOf(rig, 0);
    const auto looksSwapped = [&](const cv::Mat1b& left, const cv::Mat1b& right) {
      return EgoMotion(EgoMotionParams()).estimate(left, right, rig).swapped;
    };
    EXPECT_TRUE(looksSwapped(frame.right, frame.left)) << offset_px;
    EXPECT_FALSE(looksSwapped(frame.left, frame.right)) << offset_px;
  }
}

TEST(PrincipalOffset, BeyondTheImageIsRefused) {
  for (const double offset_px : {512.0, -576.0, 1e5}) {
    const StereoRig rig = rigWith(offset_px);
    const cv::Mat1b grey(rig.size, uchar{90});
    PipelineOutput output;
    Pipeline pipeline(params());
    try {
      pipeline.process({grey, grey, rig, Stamp(0)}, output);
      FAIL() << offset_px;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("cx_left - cx_right is"), std::string::npos);
    }
    // The next frame, of a correct calibration, is matched.
    ASSERT_TRUE(pipeline.process(frameOf(rigWith(0), 1), output));
    EXPECT_GT(cv::countNonZero(output.disparity.disparity_px >= 0), 0);
  }
}

// Almost nothing is seen by both cameras, and nothing is invented.
TEST(PrincipalOffset, NearlyBeyondTheImageGivesNothing) {
  const StereoRig rig = rigWith(505);
  PipelineOutput output;
  Pipeline pipeline(params());
  ASSERT_TRUE(pipeline.process(frameOf(rig, 0), output));
  EXPECT_LT(cv::countNonZero(output.disparity.disparity_px >= 0), 0.01 * rig.size.area());
}

}  // namespace
}  // namespace predictive_stereo
