/// A part of the robot that the camera sees: it stays in place in the image, has more texture than
/// the street, and is nearer than most of it.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "evaluation/simulation/street.h"
#include "predictive_stereo/pipeline.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr int kFrames = 8, kDisparityPx = 40;

struct Drive {
  double error_m = 0, moved_m = 0;  ///< of all frames
  int known = 0;                    ///< frames
  size_t objects = 0;
  PipelineOutput output;  ///< of the last frame
};

class RobotMask : public testing::Test {
 protected:
  RobotMask()
      : street_([] {
          StreetParams params;
          params.scene = "static";
          params.width = 620;
          params.height = 188;
          return params;
        }()) {
    part_ = cv::Rect(0, street_.rig().size.height * 4 / 5, street_.rig().size.width,
                     street_.rig().size.height / 5);
    cv::Mat1b noise(part_.height, part_.width + kDisparityPx);
    cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 255);
    cv::GaussianBlur(noise, texture_, {}, 1);
    mask_ = cv::Mat1b(street_.rig().size, uchar{0});
    mask_(part_) = 255;
  }

  Drive drive(const cv::Mat1b& mask) const {
    Pipeline pipeline{PipelineParams()};
    Drive drive;
    Eigen::Isometry3d T_world_previous;
    for (int k = 0; k < kFrames; ++k) {
      StreetFrame now = street_.render(k);
      texture_.colRange(0, part_.width).copyTo(now.left(part_));
      texture_.colRange(kDisparityPx, kDisparityPx + part_.width).copyTo(now.right(part_));
      pipeline.process({now.left, now.right, street_.rig(), stampFromSeconds(now.stamp_s), mask},
                       drive.output);
      const EgoMotionEstimate& estimate = drive.output.ego_motion;
      if (k > 0 && estimate.state == PoseState::kKnown) {
        const Eigen::Isometry3d T_true = relative(now.T_world_cam, T_world_previous);
        drive.error_m += (estimate.motion.T_cam_prev.translation() - T_true.translation()).norm();
        drive.moved_m += T_true.translation().norm();
        ++drive.known;
      }
      T_world_previous = now.T_world_cam;
      drive.objects += drive.output.detections.objects.size();
    }
    return drive;
  }

  const Street street_;
  cv::Rect part_;
  cv::Mat1b texture_, mask_;
};

TEST_F(RobotMask, NothingIsMeasuredOnTheRobot) {
  // Without a mask the robot's part is taken for the static scene.
  const Drive unmasked = drive({});
  EXPECT_GT(unmasked.error_m, 0.9 * unmasked.moved_m);
  EXPECT_GT(unmasked.objects, 0u);

  const Drive masked = drive(mask_);
  EXPECT_EQ(masked.known, kFrames - 1);
  EXPECT_LT(masked.error_m, 0.02 * masked.moved_m);
  EXPECT_EQ(masked.objects, 0u);
  const DisparityOutput& maps = masked.output.disparity;
  for (const cv::Mat1f& disparity_px : {maps.measured_disparity_px, maps.disparity_px}) {
    EXPECT_EQ(cv::countNonZero(disparity_px(part_) >= 0), 0);
    const cv::Rect above(0, part_.y / 2, part_.width, part_.y / 2);
    EXPECT_GT(cv::countNonZero(disparity_px(above) >= 0), above.area() / 2);
  }
  EXPECT_EQ(cv::countNonZero(maps.disparity_variance_px2(part_)), 0);
}

TEST_F(RobotMask, OfAnotherSizeIsRefused) {
  try {
    drive(mask_(cv::Rect(0, 0, 10, 10)));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "robot_mask is 10x10 but the calibration is for 620x188");
  }
}

}  // namespace
}  // namespace predictive_stereo
