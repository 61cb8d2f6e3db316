/// The last step of matching: from the aggregated costs of a pixel to what is told of it.
#pragma once

#include <algorithm>
#include <cstdint>

namespace predictive_stereo {

/// The lowest aggregated cost of a pixel and its surroundings.
struct Winner {
  int index;          ///< into the disparity range; the smallest of equals
  uint8_t cost;       ///< lowest aggregated cost
  uint8_t below;      ///< that of index - 1; only where `inside`
  uint8_t above;      ///< that of index + 1; only where `inside`
  uint8_t runner_up;  ///< lowest cost with |index difference| > 1; 255: none
  bool inside;        ///< both neighbours belong to the pixel's window
};

/// Equi-angular fit: both flanks of the minimum have the steeper one's slope, as suits costs that
/// grow linearly. Within [-0.5, 0.5] px.
inline float subpixelOffset(const Winner& winner) {
  if (!winner.inside) return 0.0F;
  const int steeper = std::max(winner.below, winner.above) - winner.cost;
  if (steeper == 0) return 0.0F;
  return static_cast<float>(winner.below - winner.above) / static_cast<float>(2 * steeper);
}

/// See Match::ambiguity.
inline uint8_t ambiguity(const Winner& winner) {
  if (winner.runner_up == 0) return 255;
  return static_cast<uint8_t>(255 * winner.cost / winner.runner_up);
}

}  // namespace predictive_stereo
