/// The loops of ResidualGroups over one row of the lattice, compiled for every SIMD target and
/// dispatched at run time. Every target gives the same results, bit by bit.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// Side of the squares over which residuals are summed, and their reach from the centre.
constexpr int kResidualSide = 5, kResidualReach = kResidualSide / 2;

struct SeedLimits {
  float unknown;     ///< value of an unknown residual
  int fewest_known;  ///< points of a square
  float least_mean;  ///< |mean residual| of the known ones [px]
  float least_sign;  ///< |positive - negative| / known
};

enum Seed : uint8_t { kNoSeed = 0, kPositiveSeed = 1, kNegativeSeed = 2 };

/// Seeds: points with a residual of at least half of `least_mean` in whose square residuals are
/// large and of one sign. There are no seeds at the border, where squares leave the map.
/// @param residuals  rows from kResidualReach above to kResidualReach below.
/// @param pair  of each point; 2 * pair is added to its seed.
/// @param width  at least kResidualSide.
/// @returns the number of seeds.
int seedRow(const float* const residuals[kResidualSide], const uint8_t* pair, int width,
            const SeedLimits& limits, uint8_t* seeds);

}  // namespace predictive_stereo
