/// Cleaning of disparity maps.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Invalidates pixels with fewer than `min_support` of the 25 pixels of the 5x5 neighbourhood
/// (the pixel itself included) within 1 px of their disparity. In place.
void filterBySupport(const DisparityRange& range, int min_support, cv::Mat1f& disparity_px);

/// 3x3 median of the valid neighbours of each valid pixel (section 2.3). An invalid pixel takes the
/// median where at least five of its neighbours are valid, as the paper fills "possibly invalidated
/// disparities". Not in place.
void median3x3(const DisparityRange& range, const cv::Mat1f& disparity_px, cv::Mat1f& filtered_px);

/// Fills horizontal runs of at most `max_width` invalid pixels whose two sides agree within
/// `tolerance_px`, by linear interpolation. In place.
void fillHoles(const DisparityRange& range, int max_width, float tolerance_px,
               cv::Mat1f& disparity_px);

}  // namespace predictive_stereo
