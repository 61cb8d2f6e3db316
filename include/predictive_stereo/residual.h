/// How far measurement and prediction are apart: to look at, and what the paper's detector sees.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

constexpr float kLargestResidual = 20.0f;

/// (measured - predicted) / sqrt(measured variance + predicted variance), cut to
/// +-kLargestResidual; 0 where one of the disparities is unknown. Near predicted discontinuities
/// the predicted variance is that of no prediction at all, so the residual is small there.
void normalizedResidual(const cv::Mat1f& measured_disparity_px,
                        const cv::Mat1f& measured_variance_px2,
                        const cv::Mat1f& predicted_disparity_px,
                        const cv::Mat1f& predicted_variance_px2, const DisparityRange& range,
                        cv::Mat1f& residual);

/// |measured - predicted| [px], cut to `largest_px`; 0 where one of them is unknown.
void absoluteDifference(const cv::Mat1f& measured_disparity_px,
                        const cv::Mat1f& predicted_disparity_px, const DisparityRange& range,
                        float largest_px, cv::Mat1f& difference_px);

}  // namespace predictive_stereo
