/// Winner-takes-all over the sums of a reduced search (reduced_kernel.h), for both images.
#pragma once

#include <cstdint>
#include <vector>

#include "matching/row_winners.h"
#include "matching/search_windows.h"

namespace predictive_stereo {

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

/// Fills all members of RowWinners except `agrees`.
using WindowWinnersFunction = void (*)(const WindowSums&, WindowWinnersScratch&, RowWinners&);
WindowWinnersFunction windowWinners(int64_t simd_target);

}  // namespace predictive_stereo
