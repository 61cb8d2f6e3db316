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

/// The searched pixels of such a run, which begins at a multiple of its length, share one window:
/// kernels then need to shift costs between windows only once in a run. Real ranges, which are
/// hulls over neighbours anyway, hardly grow by it.
constexpr int kWindowRun = 4;

/// Widens the hull of each run's ranges to a window around its centre, the narrowest of 16, 32, 64
/// and the whole range that holds it; windows do not leave the range.
/// @throws std::invalid_argument where the ranges' sizes are not `size`.
void planSearchWindows(const SearchRanges& ranges, const DisparityRange& range, cv::Size size,
                       SearchWindows& windows);

/// Whether every pixel searches everything, which the full search does faster.
bool isFullSearch(const SearchWindows& windows, const DisparityRange& range);

/// Every pixel searches everything.
void planFullSearch(const DisparityRange& range, cv::Size size, SearchWindows& windows);

}  // namespace predictive_stereo
