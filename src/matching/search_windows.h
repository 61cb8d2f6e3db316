/// From the ranges that a caller asks for to the windows that the kernels search.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// The window of each pixel, as indices into the disparity range (0 is min_disparity).
struct SearchWindows {
  cv::Mat1b first;  ///< first index
  cv::Mat1w width;  ///< 16, 32, 64 or the whole range; 0: not searched
};

/// Pixels of a row come in runs of this many that share one window width: kernels like it so.
constexpr int kWindowRun = 4;

/// Widens each range to a window around its centre. The width is the narrowest of 16, 32, 64 and
/// the whole range that holds every range of the pixel's run; windows do not leave the range.
/// @throws std::invalid_argument where the ranges' sizes are not `size`.
void planSearchWindows(const SearchRanges& ranges, const DisparityRange& range, cv::Size size,
                       SearchWindows& windows);

/// Every pixel searches everything.
void planFullSearch(const DisparityRange& range, cv::Size size, SearchWindows& windows);

}  // namespace predictive_stereo
