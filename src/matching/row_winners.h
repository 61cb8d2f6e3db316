/// The winners of a row, as kernels return them, and their conversion to a Match.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "matching/full_kernel.h"
#include "matching/principal_offset.h"
#include "matching/search_windows.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// One entry per pixel of the left image; entries of pixels that are not searched are undefined.
struct RowWinners {
  static constexpr int16_t kNoIndex = -1000;
  static constexpr int kPadding = 64;  ///< entries behind those of the row, for whole vectors

  std::vector<uint8_t> index;      ///< of the lowest sum; the smallest of equals
  std::vector<uint8_t> cost;       ///< lowest sum
  std::vector<uint8_t> below;      ///< sum at index - 1, if this is in the window
  std::vector<uint8_t> above;      ///< sum at index + 1, if this is in the window
  std::vector<uint8_t> runner_up;  ///< lowest sum with |index difference| > 1; 255: none
  std::vector<uint8_t> first;      ///< first index of the window
  /// Scratch memory of describeRow: 0: left and right disagree, 2: they differ by at most 1 px,
  /// 1: by more.
  std::vector<uint8_t> agreement;

  /// @param shifts  of columns, see PrincipalOffset::columnShifts.
  void resize(int width, const DisparityRange& shifts);

  /// Winners of the right image's pixels; kNoIndex where no sum is below 255. Columns outside the
  /// image that a shift reaches may be read: they have kNoIndex.
  int16_t* rightIndices() { return right_index_.data() + right_margin_; }
  const int16_t* rightIndices() const { return right_index_.data() + right_margin_; }

 private:
  std::vector<int16_t> right_index_;
  int right_margin_ = 0;
};

// Winner-takes-all over the striped sums of a full search (full_kernel.h), for both images.

struct StripedSums {
  int width;
  DisparityRange shifts;  ///< of columns, see PrincipalOffset
  StripedLayout layout;
  const uint8_t* sums;  ///< [x][layout.size()]
};

using StripedWinnersFunction = void (*)(const StripedSums&, RowWinners&);
StripedWinnersFunction stripedWinners(int64_t simd_target);

// The same over the sums of a reduced search (reduced_kernel.h).

/// Up to this many bytes before and behind the sums of a row may be read, but are not used.
constexpr int kRowSumsMargin = 64;

/// Scratch memory of the kernel.
struct WindowWinnersScratch {
  /// Candidates of right pixels: entry columns - 1 - x + i stands for the partner of left pixel x
  /// at disparity index i. Each pixel of a run writes to its own array.
  std::vector<uint16_t> right[kWindowRun];
  std::vector<uint16_t> lowest;  ///< 256 * lowest sum + its index
  std::vector<uint32_t> beside;  ///< four sums from index - 1 on, in memory order

  void resize(int columns, const DisparityRange& range);
};

struct WindowSums {
  int columns;
  DisparityRange shifts;  ///< of columns, see PrincipalOffset
  const WindowRun* windows;
  const uint16_t* width;  ///< of each pixel's window; 0: it is not searched
  const uint8_t* sums;
};

/// Fills all members of RowWinners except `agreement`.
using WindowWinnersFunction = void (*)(const WindowSums&, WindowWinnersScratch&, RowWinners&);
WindowWinnersFunction windowWinners(int64_t simd_target);

/// Sub-pixel disparity, left-right check and ambiguity of row y. The maps of `match` must have the
/// images' size.
/// @param first, width  the windows of this row; nullptr: everything was searched.
void describeRow(RowWinners& winners, const MatcherParams& params, const PrincipalOffset& offset,
                 int64_t simd_target, int y, const uint8_t* first, const uint16_t* width,
                 Match& match);

}  // namespace predictive_stereo
