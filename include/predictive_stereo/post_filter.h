/// Filters that remove and fill single disparities of a map.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Keeps a pixel if at least `min_support` of the 25 pixels of its 5x5 neighbourhood (the pixel
/// itself included; fewer at the image's border) are within 1 px of its disparity. All other pixels
/// become range.invalid(). Not in place.
/// @param min_support  0..25; at most 1: all valid pixels are kept.
/// @param filtered_px  output of the input's size.
/// @throws std::invalid_argument if input and output share memory.
void filterBySupport(const DisparityRange& range, int min_support, const cv::Mat1f& disparity_px,
                     cv::Mat1f& filtered_px);

/// Fills narrow holes, then applies the 3x3 median (section 2.3). Not in place.
///
/// Holes are horizontal runs of at most `max_width` invalid pixels; 0: none is filled. If the two
/// sides of a hole agree within `tolerance_px`, the hole is interpolated. If its right side is
/// nearer, and the hole at most 4 px wider than the difference of the two disparities, the hole is
/// an occlusion: the foreground hides it from the right camera. It gets the disparity of its left
/// side, the background.
///
/// Median: a valid pixel gets the median of itself and its valid neighbours (the lower one of an
/// even number). An invalid pixel gets the median of its valid neighbours if there are at least
/// five, as the paper fills "possibly invalidated disparities"; otherwise it is range.invalid().
/// @param filtered_px  output of the input's size.
/// @throws std::invalid_argument if input and output share memory.
void fillHolesAndMedian3x3(const DisparityRange& range, int max_width, float tolerance_px,
                           const cv::Mat1f& disparity_px, cv::Mat1f& filtered_px);

}  // namespace predictive_stereo
