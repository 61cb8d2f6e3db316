/// Winner-takes-all over the striped sums of a full search (full_kernel.h), for both images.
#pragma once

#include <cstdint>

#include "matching/row_winners.h"

namespace predictive_stereo {

struct StripedSums {
  int width;
  int count;
  int min_disparity;
  const uint8_t* sums;  ///< [x][count], striped over fullSearchLanes(target, count) lanes
};

using StripedWinnersFunction = void (*)(const StripedSums&, RowWinners&);
StripedWinnersFunction stripedWinners(int64_t simd_target);

}  // namespace predictive_stereo
