/// Hamming distances of census words by table look-up.
#pragma once

#include <bitset>
#include <cstdint>

namespace predictive_stereo {

/// Each value of four bits of the left word has a row of 16 distances, one for each value of the
/// four bits of the right word. A byte shuffle with this row gives the distances of 16 or more
/// right pixels at once, without a population count.
struct CostTables {
  explicit CostTables(int p2) {
    for (unsigned left = 0; left < 16; ++left)
      for (unsigned right = 0; right < 16; ++right) {
        const unsigned at = 16 * left + right;
        distance[at] = static_cast<uint8_t>(std::bitset<4>(left ^ right).count());
        distance_and_p2[at] = static_cast<uint8_t>(distance[at] + p2);
      }
  }

  // Row after row. The planes of the left image hold the positions where rows begin.
  alignas(64) uint8_t distance[16 * 16];
  alignas(64) uint8_t distance_and_p2[16 * 16];  ///< P2 included, for the first four bits of a word
};

}  // namespace predictive_stereo
