/// The last step of matching: the result of a pixel from its aggregated costs.
#pragma once

#include <algorithm>
#include <cstdint>

namespace predictive_stereo {

/// Equi-angular fit to the lowest aggregated cost and its two neighbours: both flanks get the slope
/// of the steeper one, which suits costs that grow linearly. Within [-0.5, 0.5] px. (No branches,
/// so that compilers can vectorise it.)
inline float subpixelOffset(int below, int cost, int above) {
  const int steeper = std::max(below, above) - cost;
  return static_cast<float>(below - above) / static_cast<float>(std::max(2 * steeper, 1));
}

/// The disparity of a sub-pixel winner, see PrincipalOffset: what remains below the range counts as
/// its lowest disparity, as it does without an offset, where that one is the nearest to it.
inline float withoutFraction(float winner_px, float fraction_px, int lowest_px) {
  return std::max(winner_px - fraction_px, static_cast<float>(lowest_px));
}

/// See Match::ambiguity. For such small integers the single-precision quotient truncates correctly.
inline uint8_t ambiguity(int cost, int runner_up) {
  const int ratio =
      static_cast<int>(static_cast<float>(255 * cost) / static_cast<float>(std::max(runner_up, 1)));
  return static_cast<uint8_t>(runner_up == 0 ? 255 : ratio);
}

}  // namespace predictive_stereo
