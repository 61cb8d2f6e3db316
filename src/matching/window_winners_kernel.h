/// Winner-takes-all over the sums of a reduced search (reduced_kernel.h), for both images.
#pragma once

#include <cstdint>
#include <vector>

#include "matching/row_winners.h"
#include "matching/search_windows.h"

namespace predictive_stereo {

/// Sums may be read, though not used, that many bytes before and behind a row's.
constexpr int kRowSumsMargin = 64;

/// Memory of the kernel.
struct WindowWinnersScratch {
  /// Candidates of right pixels: entry columns - 1 - x + i stands for the partner of left pixel x
  /// at disparity index i. Pixels of a run write to one each.
  std::vector<uint16_t> right[kWindowRun];
  std::vector<uint16_t> lowest;  ///< 256 * lowest sum + its index
  std::vector<uint32_t> beside;  ///< four sums from the one below the lowest on, in memory's order

  void resize(int columns, const DisparityRange& range);
};

struct WindowSums {
  int columns;
  DisparityRange range;
  const WindowRun* windows;
  const uint16_t* width;  ///< of each pixel's window; 0: it is not searched
  const uint8_t* sums;
};

/// Fills all members of RowWinners but `agrees`.
using WindowWinnersFunction = void (*)(const WindowSums&, WindowWinnersScratch&, RowWinners&);
WindowWinnersFunction windowWinners(int64_t simd_target);

}  // namespace predictive_stereo
