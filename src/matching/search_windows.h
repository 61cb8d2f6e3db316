/// Conversion of search ranges to the windows that the kernels search.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Length of a run: pixels that share one window. Runs begin at multiples of it. Kernels then shift
/// costs between windows only once per run. Ranges hardly grow by this, as they are hulls over
/// neighbours anyway.
constexpr int kWindowRun = 4;

/// The window of a run (or of a pixel, see planExactWindows), as indices into the disparity range
/// (0 is min_disparity).
struct WindowRun {
  int position;    ///< of its first byte among those of its row; each pixel has `width` bytes
  uint16_t width;  ///< 16, 32, 64, the whole range, or exact; 0: none of its pixels is searched
  uint8_t first;   ///< first index
};

struct SearchWindows {
  int run_length = kWindowRun;  ///< 1 if each pixel has its own window
  int runs_per_row = 0;
  std::vector<WindowRun> runs;  ///< row by row
  /// Position of each row's first byte among those of the image; the last entry is their number.
  std::vector<size_t> row_begins;
  /// For each pixel the width of its run's window, or 0 if the pixel itself is not searched. Paths
  /// pass through all pixels of a run, also through these.
  cv::Mat1w width;

  const WindowRun* row(int y) const { return &runs[static_cast<size_t>(y) * runs_per_row]; }
  WindowRun* row(int y) { return &runs[static_cast<size_t>(y) * runs_per_row]; }
};

/// Widens the hull of each run's ranges to a window around its centre, the narrowest of 16, 32, 64
/// and the whole range that holds it; windows do not leave the range.
/// @param between  whether disparities are between two indices (PrincipalOffset::fraction_px > 0):
///   then one more index is needed to reach `last`.
/// @throws std::invalid_argument if the sizes of the ranges differ from `size`.
void planSearchWindows(const SearchRanges& ranges, const DisparityRange& range, bool between,
                       cv::Size size, int64_t simd_target, SearchWindows& windows);

/// Gives every pixel its own window: its range, cut to `range`. Only matchReference can search such
/// windows.
/// @param between  as in planSearchWindows.
/// @throws std::invalid_argument if the sizes of the ranges differ from `size`.
void planExactWindows(const SearchRanges& ranges, const DisparityRange& range, bool between,
                      cv::Size size, SearchWindows& windows);

/// Whether every pixel searches the whole range; the full search is faster then.
bool isFullSearch(const SearchWindows& windows, const DisparityRange& range);

/// Every pixel searches the whole range.
void planFullSearch(const DisparityRange& range, cv::Size size, SearchWindows& windows);

// Parts of planSearchWindows.

/// Plans the runs of a row, except for their positions, and the width of each pixel.
/// @param first, last  the row's ranges, `columns` of them.
using PlanRowFunction = void (*)(const short* first, const short* last, int columns,
                                 const DisparityRange& range, WindowRun* runs,
                                 uint16_t* pixel_width);

/// The reference in plain C++ that the kernels must equal: one run after the other.
void planRowReference(const short* first, const short* last, int columns,
                      const DisparityRange& range, WindowRun* runs, uint16_t* pixel_width);

/// The kernel of a target; for the scalar target, the reference.
PlanRowFunction planRow(int64_t simd_target);

}  // namespace predictive_stereo
