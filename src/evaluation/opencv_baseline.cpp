#include "evaluation/opencv_baseline.h"

#include <opencv2/calib3d.hpp>

namespace predictive_stereo {

void opencvDisparity(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityRange& range,
                     OpencvMode mode, cv::Mat1f& disparity_px, double principal_offset_px) {
  constexpr int kBlock = 3, kP1 = 26, kP2 = 470;
  const int first = range.min_disparity + cvFloor(principal_offset_px);
  const auto matcher = cv::StereoSGBM::create(first, range.count, kBlock, kP1, kP2);
  matcher->setMode(mode == OpencvMode::kHh ? cv::StereoSGBM::MODE_HH
                                           : cv::StereoSGBM::MODE_SGBM_3WAY);
  cv::Mat1s fixed_point;
  matcher->compute(left, right, fixed_point);
  fixed_point.convertTo(disparity_px, CV_32F, 1.0 / cv::StereoMatcher::DISP_SCALE,
                        -principal_offset_px);
  if (principal_offset_px == 0) return;
  const cv::Mat1b unknown = fixed_point < first * cv::StereoMatcher::DISP_SCALE;
  cv::max(disparity_px, static_cast<double>(range.min_disparity), disparity_px);
  disparity_px.setTo(range.invalid(), unknown);
}

}  // namespace predictive_stereo
