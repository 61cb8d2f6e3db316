/// Winner-takes-all over the striped sums of a full search (full_kernel.h), for both images.
#pragma once

#include <cstdint>

#include "matching/full_kernel.h"
#include "matching/row_winners.h"

namespace predictive_stereo {

struct StripedSums {
  int width;
  DisparityRange shifts;  ///< of columns, see PrincipalOffset
  StripedLayout layout;
  const uint8_t* sums;  ///< [x][layout.size()]
};

using StripedWinnersFunction = void (*)(const StripedSums&, RowWinners&);
StripedWinnersFunction stripedWinners(int64_t simd_target);

}  // namespace predictive_stereo
