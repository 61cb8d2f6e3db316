#include "evaluation/opencv_baseline.h"

#include <opencv2/calib3d.hpp>

namespace predictive_stereo {

void opencvDisparity(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityRange& range,
                     OpencvMode mode, cv::Mat1f& disparity_px) {
  constexpr int kBlock = 3, kP1 = 26, kP2 = 470;
  const auto matcher = cv::StereoSGBM::create(range.min_disparity, range.count, kBlock, kP1, kP2);
  matcher->setMode(mode == OpencvMode::kHh ? cv::StereoSGBM::MODE_HH
                                           : cv::StereoSGBM::MODE_SGBM_3WAY);
  cv::Mat1s fixed_point;
  matcher->compute(left, right, fixed_point);
  fixed_point.convertTo(disparity_px, CV_32F, 1.0 / cv::StereoMatcher::DISP_SCALE);
}

}  // namespace predictive_stereo
