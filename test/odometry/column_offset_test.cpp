/// Rigs whose right camera was turned after the calibration: the ego-motion estimates the column
/// offset and its uncertainty, and its motions are as without an offset.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "evaluation/simulation/street.h"
#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {
namespace {

struct Pair {
  cv::Mat1b left, right;
  Eigen::Isometry3d T_world_cam;
};

// The right image, shifted to the right, as after a small turn of that camera.
cv::Mat1b shiftedRight(const cv::Mat1b& right, double shift_px) {
  const cv::Matx23d shift(1, 0, shift_px, 0, 1, 0);
  cv::Mat1b shifted;
  cv::warpAffine(right, shifted, shift, right.size(), cv::INTER_LANCZOS4, cv::BORDER_REPLICATE);
  return shifted;
}

StereoRig streetRig() {
  static const StereoRig rig = Street(StreetParams()).rig();
  return rig;
}

std::vector<Pair> drive(const std::string& scene, int first, int frames) {
  StreetParams params;
  params.scene = scene;
  const Street street(params);
  std::vector<Pair> pairs;
  for (int k = first; k < first + frames; ++k) {
    StreetFrame frame = street.render(k);
    pairs.push_back({frame.left, frame.right, frame.T_world_cam});
  }
  return pairs;
}

// Returns the estimate for the last pair, and the length of the path.
EgoMotionEstimate follow(const std::vector<Pair>& pairs, double shift_px, double& length_m) {
  EgoMotion ego_motion{EgoMotionParams()};
  EgoMotionEstimate estimate;
  length_m = 0;
  for (const Pair& pair : pairs) {
    estimate = ego_motion.estimate(pair.left, shiftedRight(pair.right, shift_px), streetRig());
    length_m += estimate.motion.T_cam_prev.translation().norm();
  }
  return estimate;
}

TEST(ColumnOffset, IsFoundWithinAFewFrames) {
  const std::vector<Pair> pairs = drive("turn", 20, 8);
  double true_m = 0;
  for (size_t k = 1; k < pairs.size(); ++k)
    true_m += (pairs[k - 1].T_world_cam.inverse() * pairs[k].T_world_cam).translation().norm();
  for (const double shift_px : {0.0, 0.5, 1.0, 2.0, -1.0}) {
    double length_m = 0;
    const EgoMotionEstimate estimate = follow(pairs, shift_px, length_m);
    const double error_px = estimate.disparity_offset_px - shift_px;
    EXPECT_LT(estimate.disparity_offset_sigma_px, 0.05) << shift_px;
    EXPECT_LT(std::abs(error_px), 3 * estimate.disparity_offset_sigma_px) << shift_px;
    ASSERT_TRUE(estimate.column_offset.known) << shift_px;
    EXPECT_NEAR(estimate.column_offset.offset_px, shift_px, 0.1);
    EXPECT_NEAR(estimate.column_offset.correction_px, shift_px, shift_px == 0 ? 0 : 0.1);
    EXPECT_NEAR(length_m / true_m, 1, 0.005) << shift_px;
  }
}

// The image of a camera that is rotated by small angles.
cv::Mat1b turned(const cv::Mat1b& image, const StereoRig& rig, const cv::Vec3d& rotation_rad) {
  const cv::Matx33d K(rig.fx_px, 0, rig.cx_left_px, 0, rig.fy_px, rig.cy_px, 0, 0, 1);
  cv::Matx33d R;
  cv::Rodrigues(rotation_rad, R);
  cv::Mat1b result;
  cv::warpPerspective(image, result, K * R * K.inv(), image.size(), cv::INTER_LINEAR,
                      cv::BORDER_REPLICATE);
  return result;
}

// At rest the offset is not observable, for any duration and with image noise.
TEST(ColumnOffset, IsNotKnownAtRest) {
  const std::vector<Pair> pairs = drive("street", 20, 1);
  const StereoRig rig = streetRig();
  const cv::Mat1b right = shiftedRight(pairs[0].right, 2);
  for (const double tremble_px : {0.3, 1.5}) {
    EgoMotion ego_motion{EgoMotionParams()};
    std::mt19937 random(1);
    std::normal_distribution<double> angle_rad(0, tremble_px / rig.fx_px);
    cv::RNG noise(1);
    for (int k = 0; k < 100; ++k) {
      const cv::Vec3d rotation_rad(angle_rad(random), angle_rad(random), angle_rad(random));
      cv::Mat1b images[] = {turned(pairs[0].left, rig, rotation_rad),
                            turned(right, rig, rotation_rad)};
      for (cv::Mat1b& image : images) {
        cv::Mat1s grain(image.size());
        noise.fill(grain, cv::RNG::NORMAL, 0, 1.5);
        cv::add(image, grain, image, cv::noArray(), CV_8U);
      }
      const EgoMotionEstimate estimate = ego_motion.estimate(images[0], images[1], rig);
      ASSERT_NEAR(estimate.disparity_offset_px, 0, 0.1) << k;  // as at the start
      ASSERT_GE(estimate.disparity_offset_sigma_px, 1) << k;
      ASSERT_FALSE(estimate.column_offset.known) << k;
      ASSERT_EQ(estimate.column_offset.correction_px, 0) << k;
    }
  }
}

TEST(ColumnOffset, IsForgottenWithTheCalibration) {
  const std::vector<Pair> pairs = drive("turn", 20, 8);
  EgoMotion ego_motion{EgoMotionParams()};
  StereoRig rig = streetRig();
  EgoMotionEstimate estimate;
  for (const Pair& pair : pairs)
    estimate = ego_motion.estimate(pair.left, shiftedRight(pair.right, 1), rig);
  ASSERT_NEAR(estimate.column_offset.correction_px, 1, 0.1);
  ego_motion.reset();  // the same rig
  estimate = ego_motion.estimate(pairs[0].left, shiftedRight(pairs[0].right, 1), rig);
  EXPECT_NEAR(estimate.column_offset.correction_px, 1, 0.1);

  rig.cx_right_px += estimate.column_offset.offset_px;  // the cure that the diagnostics recommend
  for (const Pair& pair : pairs) {
    estimate = ego_motion.estimate(pair.left, shiftedRight(pair.right, 1), rig);
    EXPECT_EQ(estimate.column_offset.correction_px, 0);
  }
  ASSERT_TRUE(estimate.column_offset.known);
  EXPECT_NEAR(estimate.column_offset.offset_px, 0, 0.1);
}

TEST(ColumnOffset, IsUnknownWhereSwitchedOff) {
  const std::vector<Pair> pairs = drive("turn", 20, 3);
  EgoMotionParams params;
  params.estimate_disparity_offset = false;
  EgoMotion ego_motion(params);
  for (int round = 0; round < 3; ++round)
    for (const Pair& pair : pairs) {
      const EgoMotionEstimate estimate = ego_motion.estimate(pair.left, pair.right, streetRig());
      EXPECT_FALSE(estimate.column_offset.known);
      EXPECT_EQ(estimate.column_offset.correction_px, 0);
    }
}

}  // namespace
}  // namespace predictive_stereo
