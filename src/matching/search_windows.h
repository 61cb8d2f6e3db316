/// From the ranges that a caller asks for to the windows that the kernels search.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Pixels of such a run, which begins at a multiple of its length, share one window: kernels then
/// need to shift costs between windows only once in a run. Real ranges, which are hulls over
/// neighbours anyway, hardly grow by it.
constexpr int kWindowRun = 4;

/// The window of a run (or of a pixel, see planExactWindows), as indices into the disparity range
/// (0 is min_disparity).
struct WindowRun {
  int position;    ///< where its bytes begin among those of its row: `width` for each pixel
  uint16_t width;  ///< 16, 32, 64, the whole range, or exact; 0: no pixel of it is searched
  uint8_t first;   ///< first index
};

struct SearchWindows {
  int run_length = kWindowRun;  ///< 1 where each pixel has a window of its own
  int runs_per_row = 0;
  std::vector<WindowRun> runs;  ///< row by row
  /// Where the bytes of each row begin among those of the image; the last entry is their number.
  std::vector<size_t> row_begins;
  /// Of each pixel: the width of its run's window, or 0 where it is not searched itself. Paths lead
  /// through all pixels of a run, also through those.
  cv::Mat1w width;

  const WindowRun* row(int y) const { return &runs[static_cast<size_t>(y) * runs_per_row]; }
  WindowRun* row(int y) { return &runs[static_cast<size_t>(y) * runs_per_row]; }
};

/// Widens the hull of each run's ranges to a window around its centre, the narrowest of 16, 32, 64
/// and the whole range that holds it; windows do not leave the range.
/// @throws std::invalid_argument where the ranges' sizes are not `size`.
void planSearchWindows(const SearchRanges& ranges, const DisparityRange& range, cv::Size size,
                       int64_t simd_target, SearchWindows& windows);

/// Every pixel has a window of its own, which is its range, cut to `range`. Only matchReference can
/// search such windows.
/// @throws std::invalid_argument where the ranges' sizes are not `size`.
void planExactWindows(const SearchRanges& ranges, const DisparityRange& range, cv::Size size,
                      SearchWindows& windows);

/// Whether every pixel searches everything, which the full search does faster.
bool isFullSearch(const SearchWindows& windows, const DisparityRange& range);

/// Every pixel searches everything.
void planFullSearch(const DisparityRange& range, cv::Size size, SearchWindows& windows);

}  // namespace predictive_stereo
