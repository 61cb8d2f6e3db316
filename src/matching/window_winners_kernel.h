/// Winner-takes-all over the sums of a reduced search (reduced_kernel.h), for both images.
#pragma once

#include <cstdint>

#include "matching/reduced_kernel.h"
#include "matching/row_winners.h"

namespace predictive_stereo {

struct WindowSums {
  int columns;
  DisparityRange range;
  WindowRow windows;
  const uint8_t* sums;
  /// columns - 1 + count entries of scratch memory, 16 more at the end.
  uint16_t* right_scratch;
};

using WindowWinnersFunction = void (*)(const WindowSums&, RowWinners&);
WindowWinnersFunction windowWinners(int64_t simd_target);

}  // namespace predictive_stereo
