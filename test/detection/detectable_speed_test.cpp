#include "predictive_stereo/detectable_speed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "detection/constants.h"
#include "detection/motion_noise.h"
#include "detection/point_tracks.h"

namespace predictive_stereo {
namespace {

StereoRig kittiRig() {
  StereoRig rig;
  rig.size = {1242, 375};
  rig.fx_px = rig.fy_px = 721.5;
  rig.cx_left_px = rig.cx_right_px = 609.5;
  rig.cy_px = 172.8;
  rig.baseline_m = 0.5372;
  return rig;
}

TEST(DetectableSpeed, AcrossTheLineOfSightIsAFewPixels) {
  const StereoRig rig = kittiRig();
  const MotionDetectionParams params;
  // Noise of the point and of the ego-motion, over two frames.
  const double at_60_m =
      std::sqrt(params.min_mahalanobis) *
      std::hypot(kFlowSigma_px, std::sqrt(2) * rig.fx_px *
                                    std::hypot(kUntoldMotionSigma_m / 60, kUntoldMotionSigma_rad));
  EXPECT_NEAR(detectableSpeed(rig, 60, 0.1).across_mps, at_60_m * 60 / rig.fx_px / 0.2, 1e-9);
}

TEST(DetectableSpeed, AlongItGrowsWithTheSquareOfDistance) {
  const StereoRig rig = kittiRig();
  const double fB = rig.disparityTimesDepth();
  for (double depth_m : {5.0, 20.0, 60.0}) {
    const double moved_m = 0.2 * detectableSpeed(rig, depth_m, 0.1).along_mps;
    EXPECT_NEAR(fB / depth_m - fB / (depth_m + moved_m),
                MotionDetectionParams().dense_min_residual_px, 1e-9)
        << depth_m;
  }
  EXPECT_NEAR(detectableSpeed(rig, 20, 0.1).along_mps, 3.75, 0.05);
  EXPECT_TRUE(std::isinf(detectableSpeed(rig, 600, 0.1).along_mps)) << "disparity 0.65 px";
}

TEST(DetectableSpeed, FollowsFromRigRateAndThresholds) {
  const StereoRig rig = kittiRig();
  const DetectableSpeed base = detectableSpeed(rig, 30, 0.1);
  const DetectableSpeed fast = detectableSpeed(rig, 30, 0.05);
  EXPECT_DOUBLE_EQ(fast.across_mps, 2 * base.across_mps) << "less way until the first past frame";
  EXPECT_DOUBLE_EQ(fast.along_mps, base.along_mps);
  const DetectableSpeed slow = detectableSpeed(rig, 30, 0.2);
  EXPECT_DOUBLE_EQ(slow.across_mps, 0.5 * base.across_mps);
  EXPECT_DOUBLE_EQ(slow.along_mps, 0.5 * base.along_mps);
  StereoRig wide = rig;
  wide.baseline_m *= 2;
  EXPECT_DOUBLE_EQ(detectableSpeed(wide, 30, 0.1).across_mps, base.across_mps);
  EXPECT_LT(detectableSpeed(wide, 30, 0.1).along_mps, 0.5 * base.along_mps);
  StereoRig sharp = rig;
  sharp.fx_px *= 2;
  EXPECT_LT(detectableSpeed(sharp, 100, 0.1).across_mps, detectableSpeed(rig, 100, 0.1).across_mps);
  MotionDetectionParams params;
  params.dense_min_residual_px = 0.5;
  EXPECT_LT(detectableSpeed(rig, 30, 0.1, params).along_mps, base.along_mps);
  params = MotionDetectionParams();
  params.min_mahalanobis *= 2;
  EXPECT_GT(detectableSpeed(rig, 30, 0.1, params).across_mps, base.across_mps);
  params.dense_min_residual_px = 100;  // only points
  VarianceParams noisy;
  noisy.sigma_floor_px = 1;
  EXPECT_GT(detectableSpeed(rig, 30, 0.1, params, noisy).along_mps,
            detectableSpeed(rig, 30, 0.1, params).along_mps);
}

// The detector enlarges the images of a small camera, here of the same view.
TEST(DetectableSpeed, OfASmallCameraIsThatOfTheRescaledImages) {
  const StereoRig rig = kittiRig();
  StereoRig half = rig;
  half.size = {621, 188};
  for (double* px : {&half.fx_px, &half.fy_px, &half.cx_left_px, &half.cx_right_px, &half.cy_px})
    *px *= 0.5;
  for (const double depth_m : {10.0, 40.0}) {
    const DetectableSpeed speed = detectableSpeed(rig, depth_m, 0.1),
                          of_half = detectableSpeed(half, depth_m, 0.1);
    EXPECT_NEAR(of_half.across_mps, speed.across_mps, 0.01 * speed.across_mps);
    EXPECT_NEAR(of_half.along_mps, speed.along_mps, 0.01 * speed.along_mps);
  }
}

TEST(DetectableSpeed, RefusesWhatIsNotPositive) {
  EXPECT_THROW(detectableSpeed(kittiRig(), 0, 0.1), std::invalid_argument);
  EXPECT_THROW(detectableSpeed(kittiRig(), 10, -0.1), std::invalid_argument);
  EXPECT_THROW(detectableSpeed(kittiRig(), NAN, 0.1), std::invalid_argument);
}

// A textured board of 2.2 x 1.6 m before a far wall, and a standing camera: exact images and
// disparities.
class Board {
 public:
  Board(double depth_m, double across_mps, double along_mps)
      : depth_m_(depth_m), across_mps_(across_mps), along_mps_(along_mps) {
    cv::RNG random(5);
    wall_ = texture(rig_.size, random);
    board_ = texture({880, 640}, random);
  }

  // The largest number of objects found in a frame.
  int found(double interval_s = 0.1) {
    MovingObjectDetector detector{DetectionParams()};
    Detections detections;
    DetectionInput input;
    input.rig = rig_;
    input.pose_state = PoseState::kKnown;
    size_t most = 0;
    for (double time_s = 0; time_s < 0.45; time_s += interval_s) {
      input.stamp_s = time_s;
      cv::Mat1f disparity_px;
      draw(input.stamp_s, input.left, disparity_px);
      input.measured_disparity_px = disparity_px;
      input.measured_variance_px2 = cv::Mat1f(rig_.size, 0.1f);
      detector.detect(input, detections);
      most = std::max(most, detections.objects.size());
    }
    return static_cast<int>(most);
  }

 private:
  // Patterns of 4 to 64 pixels.
  static cv::Mat1b texture(cv::Size size, cv::RNG& random) {
    cv::Mat1f sum = cv::Mat1f::zeros(size);
    for (int grain = 4; grain <= 64; grain *= 2) {
      cv::Mat1f noise(size / grain + cv::Size(2, 2));
      random.fill(noise, cv::RNG::UNIFORM, -1, 1);
      cv::resize(noise, noise, size, 0, 0, cv::INTER_CUBIC);
      sum += noise;
    }
    cv::Mat1b grey;
    cv::normalize(sum, grey, 20, 235, cv::NORM_MINMAX, CV_8U);
    return grey;
  }

  void draw(double time_s, cv::Mat1b& left, cv::Mat1f& disparity_px) const {
    const double depth_m = depth_m_ - along_mps_ * time_s;
    // Resized to nearly its size by averaging, then by interpolation.
    const cv::Size size(cvRound(2.2 * rig_.fx_px / depth_m_), cvRound(1.6 * rig_.fx_px / depth_m_));
    cv::Mat1b texture;
    cv::resize(board_, texture, size, 0, 0, cv::INTER_AREA);
    const double scale = depth_m_ / depth_m;
    const double column = rig_.cx_left_px + rig_.fx_px * (across_mps_ * time_s) / depth_m;
    const cv::Matx23d warp(scale, 0, column - 0.5 * scale * size.width, 0, scale,
                           rig_.cy_px - 0.5 * scale * size.height);
    cv::Mat1b board, covered;
    cv::warpAffine(texture, board, warp, rig_.size, cv::INTER_LINEAR);
    cv::warpAffine(cv::Mat1b(size, uchar{255}), covered, warp, rig_.size, cv::INTER_NEAREST);
    left = wall_.clone();
    board.copyTo(left, covered);
    disparity_px = cv::Mat1f(rig_.size, static_cast<float>(rig_.disparityTimesDepth() / 60));
    disparity_px.setTo(rig_.disparityTimesDepth() / depth_m, covered);
  }

  StereoRig rig_ = kittiRig();
  double depth_m_, across_mps_, along_mps_;
  cv::Mat1b wall_, board_;
};

TEST(DetectableSpeed, IsWhatTheDetectorDetects) {
  for (double depth_m : {12.0, 25.0, 40.0}) {
    const DetectableSpeed limit = detectableSpeed(kittiRig(), depth_m, 0.1);
    EXPECT_EQ(Board(depth_m, 1.4 * limit.across_mps, 0).found(), 1) << "across at " << depth_m;
    EXPECT_EQ(Board(depth_m, 0.5 * limit.across_mps, 0).found(), 0) << "across at " << depth_m;
    constexpr double kFast_s = 0.03;
    const double fast_mps = detectableSpeed(kittiRig(), depth_m, kFast_s).across_mps;
    EXPECT_EQ(Board(depth_m, 1.4 * fast_mps, 0).found(kFast_s), 1) << "across at " << depth_m;
    EXPECT_EQ(Board(depth_m, 0.5 * fast_mps, 0).found(kFast_s), 0) << "across at " << depth_m;
  }
  for (double depth_m : {12.0, 25.0}) {
    const DetectableSpeed limit = detectableSpeed(kittiRig(), depth_m, 0.1);
    EXPECT_EQ(Board(depth_m, 0, 1.4 * limit.along_mps).found(), 1) << "along at " << depth_m;
    // Older frames detect slower motion, but not this slow.
    EXPECT_EQ(Board(depth_m, 0, 0.1 * limit.along_mps).found(), 0) << "along at " << depth_m;
  }
}

}  // namespace
}  // namespace predictive_stereo
