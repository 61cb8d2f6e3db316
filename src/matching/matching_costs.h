/// Hamming distances of census words by table look-up.
#pragma once

#include <cstdint>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Costs by table look-up: for the four bits of the left word, a row of 16 costs, one for each
/// value of the four bits of the right word. A byte shuffle then gives the costs of 16 or more
/// right pixels at once, without a population count.
struct CostTables {
  explicit CostTables(int p2);

  alignas(64) uint8_t distance[16][16];
  alignas(64) uint8_t distance_and_p2[16][16];  ///< P2 included, for the first four bits of a word
};

/// Groups of four bits in a word of this census form: 6 or 8.
int nibbleCount(CensusForm form);

}  // namespace predictive_stereo
