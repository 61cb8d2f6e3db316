#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "evaluation/disparity_evaluation.h"
#include "evaluation/disparity_metrics.h"
#include "evaluation/lidar_truth.h"
#include "tools/kitti_drive.h"

namespace predictive_stereo {
namespace {

TEST(OpencvBaseline, FindsAShiftAndMarksTheRest) {
  cv::Mat1b left(80, 300);
  cv::RNG random(1);
  random.fill(left, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(left, left, {}, 1.0);
  cv::Mat1b right(left.size(), uchar{0});
  left.colRange(10, 300).copyTo(right.colRange(0, 290));
  for (const int mode : {cv::StereoSGBM::MODE_HH, cv::StereoSGBM::MODE_SGBM_3WAY}) {
    cv::Mat1f disparity_px;
    opencvDisparity(left, right, DisparityRange{}, mode, disparity_px);
    EXPECT_NEAR(disparity_px(40, 200), 10, 0.1);
    EXPECT_EQ(disparity_px(40, 50), -1);  // the first `count` columns are invalid in OpenCV
  }
}

/// The figures are those of an independent program. The tolerance allows for other OpenCV versions.
TEST(OpencvBaseline, ReproducesKnownFiguresOnKitti) {
  const char* excerpts = std::getenv("KITTI_EXCERPTS");
  if (!excerpts) GTEST_SKIP() << "KITTI_EXCERPTS is not set";
  const KittiDrive drive(std::string(excerpts) + "/2011_09_26", "2011_09_26_drive_0002_sync");
  MeanDisparityScore mean;
  for (int frame = 1; frame < drive.frames(); ++frame) {
    cv::Mat1f disparity_px;
    opencvDisparity(drive.left(frame), drive.right(frame), DisparityRange{},
                    cv::StereoSGBM::MODE_HH, disparity_px);
    mean.add(scoreDisparity(disparity_px, DisparityRange{}, lidarTruth(drive, frame)));
  }
  EXPECT_NEAR(mean.d1_percent, 3.4, 0.1);
  EXPECT_NEAR(mean.d1_filled_percent, 10.6, 0.1);
  EXPECT_NEAR(mean.density_percent, 92.6, 0.1);
}

}  // namespace
}  // namespace predictive_stereo
