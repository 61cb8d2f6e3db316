/// The loops of ResidualGroups over one row of the lattice, compiled for every SIMD target and
/// dispatched at run time. Every target gives the same results, bit by bit.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// Side of the squares over which residuals are summed, and how far these reach.
constexpr int kResidualSide = 5, kResidualReach = kResidualSide / 2;

struct SeedLimits {
  float unknown;     ///< stands for a residual that is not known
  int fewest_known;  ///< of a square's points
  float least_mean;  ///< |mean residual| of the known ones [px]
  float least_sign;  ///< |positive - negative| / known
};

enum Seed : uint8_t { kNoSeed = 0, kPositiveSeed = 1, kNegativeSeed = 2 };

/// Points with a residual at least half as large as `least_mean`, in whose square residuals are
/// large and of one sign. Squares reach beyond the map at its border: there are no seeds there.
/// @param residuals  rows from kResidualReach above to kResidualReach below.
/// @param pair  of each point: 2 pair is added to its seed.
/// @param width  at least kResidualSide.
/// @return how many.
int seedRow(const float* const residuals[kResidualSide], const uint8_t* pair, int width,
            const SeedLimits& limits, uint8_t* seeds);

}  // namespace predictive_stereo
