/// The loops of DenseGroups over one row of the lattice, compiled for every SIMD target and
/// dispatched at run time. Every target gives the same results, bit by bit.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// Side of the squares over which residuals are summed, and how far these reach.
constexpr int kDenseSide = 7, kDenseReach = kDenseSide / 2;

struct SeedLimits {
  float unknown;     ///< stands for a residual that is not known
  int fewest_known;  ///< of a square's points
  float least_mean;  ///< |mean residual| of the known ones [px]
  float least_sign;  ///< |positive - negative| / known
};

enum Seed : uint8_t { kNoSeed = 0, kPositiveSeed = 1, kNegativeSeed = 2 };

/// Points whose residual is known and in whose square residuals are large and of one sign.
/// @param residuals  rows from kDenseReach above to kDenseReach below; all unknown
///   outside of the map.
/// @return how many.
int seedRow(const float* const residuals[kDenseSide], int width, const SeedLimits& limits,
            uint8_t* seeds);

/// The same for squares of kSlowSide, but for points around which they lie within the map; the
/// residual of the point itself must be at least half as large.
/// @param width  at least kSlowSide.
/// @param pair  of each point: 2 pair is added to its seed.
constexpr int kSlowSide = 5, kSlowReach = kSlowSide / 2;
int slowSeedRow(const float* const residuals[kSlowSide], const uint8_t* pair, int width,
                const SeedLimits& limits, uint8_t* seeds);

}  // namespace predictive_stereo
