/// The last step of matching: from the aggregated costs of a pixel to its result.
#pragma once

#include <algorithm>
#include <cstdint>

namespace predictive_stereo {

/// Equi-angular fit to the lowest aggregated cost and those beside it: both flanks have the steeper
/// one's slope, as suits costs that grow linearly. Within [-0.5, 0.5] px. (Written without branches
/// for the compiler to vectorise.)
inline float subpixelOffset(int below, int cost, int above) {
  const int steeper = std::max(below, above) - cost;
  return static_cast<float>(below - above) / static_cast<float>(std::max(2 * steeper, 1));
}

/// See Match::ambiguity. The quotient of such small integers is exact enough in single precision to
/// be cut off correctly.
inline uint8_t ambiguity(int cost, int runner_up) {
  const int ratio =
      static_cast<int>(static_cast<float>(255 * cost) / static_cast<float>(std::max(runner_up, 1)));
  return static_cast<uint8_t>(runner_up == 0 ? 255 : ratio);
}

}  // namespace predictive_stereo
