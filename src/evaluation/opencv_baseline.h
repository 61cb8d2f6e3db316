#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

enum class OpencvMode {
  kHh,    ///< StereoSGBM::MODE_HH, 8 paths: the paper's baseline
  k3Way,  ///< StereoSGBM::MODE_SGBM_3WAY: OpenCV's fastest
};

/// OpenCV's semi-global matching with the paper's parameters (P1 26, P2 470, block 3; OpenCV's
/// defaults for all others).
/// @param disparity_px  range.invalid() where OpenCV finds nothing.
/// @param principal_offset_px  is subtracted, as in this package; see StereoRig::principalOffset.
void opencvDisparity(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityRange& range,
                     OpencvMode mode, cv::Mat1f& disparity_px, double principal_offset_px = 0);

}  // namespace predictive_stereo
