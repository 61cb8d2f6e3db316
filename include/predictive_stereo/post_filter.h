/// Cleaning of disparity maps.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Keeps the pixels that have at least `min_support` of the 25 pixels of their 5x5 neighbourhood
/// (the pixel itself included; fewer at the image's border) within 1 px of their disparity, and
/// invalidates all others. Not in place.
/// @throws std::invalid_argument where input and output are the same memory.
void filterBySupport(const DisparityRange& range, int min_support, const cv::Mat1f& disparity_px,
                     cv::Mat1f& filtered_px);

/// Fills narrow holes, then takes the 3x3 median (section 2.3); row by row while it is in the
/// cache. Not in place.
///
/// Holes are horizontal runs of at most `max_width` invalid pixels; 0: none is filled. Where their
/// two sides agree within `tolerance_px` they are interpolated. Where the right side is nearer, and
/// the run at most 4 px wider than the two disparities' difference, it is what the near surface
/// hides from the right camera, and takes the disparity of its left side.
///
/// Median: a valid pixel takes that of the valid pixels around it and of itself (of an even number
/// the lower one). An invalid pixel takes that of its valid neighbours where there are at least
/// five, as the paper fills "possibly invalidated disparities".
/// @throws std::invalid_argument where input and output are the same memory.
void fillHolesAndMedian3x3(const DisparityRange& range, int max_width, float tolerance_px,
                           const cv::Mat1f& disparity_px, cv::Mat1f& filtered_px);

}  // namespace predictive_stereo
