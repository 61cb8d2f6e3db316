/// Difference between measured and predicted disparity: for display, and for the paper's detector.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

constexpr float kLargestResidual = 20.0f;  ///< in standard deviations

/// (measured - predicted) / sqrt(measured variance + predicted variance), clamped to
/// +-kLargestResidual; 0 where one of the disparities is unknown. Near predicted discontinuities
/// the predicted variance covers the whole range (see Prediction), so the residual is small there.
/// All maps must have one size; this is not checked.
/// @param residual  output of that size, without unit.
void normalizedResidual(const cv::Mat1f& measured_disparity_px,
                        const cv::Mat1f& measured_variance_px2,
                        const cv::Mat1f& predicted_disparity_px,
                        const cv::Mat1f& predicted_variance_px2, const DisparityRange& range,
                        cv::Mat1f& residual);

/// |measured - predicted| [px], at most `largest_px`; 0 where one of them is unknown (section 4).
/// Both maps must have one size; this is not checked.
void absoluteDifference(const cv::Mat1f& measured_disparity_px,
                        const cv::Mat1f& predicted_disparity_px, const DisparityRange& range,
                        float largest_px, cv::Mat1f& difference_px);

}  // namespace predictive_stereo
