/// The loop of LevelGround over one row of the lattice, compiled for every SIMD target and
/// dispatched at run time. Every target gives the same results, bit by bit.
#pragma once

namespace predictive_stereo {

/// Disparities are compared over 1, ..., kMostGroundReach lattice rows up and down.
constexpr int kMostGroundReach = 4;

struct GroundLimits {
  float smallest_px;          ///< smallest valid disparity; only those above 0 are used
  float reach_by_disparity;   ///< [lattice rows / px]
  float horizon_distance_px;  ///< of the row, positive below
  float baseline_m;
  float least_share, most_share;  ///< of a level surface's growth
};

/// Distance of a row's points below the camera [m] if the disparity grows as on a level surface; 0
/// elsewhere.
/// @param above, beneath  rows at distances 1, ... from it; null outside the map. Every second
///   float of all rows is used.
void levelRow(const float* disparity_px, const float* const above[kMostGroundReach],
              const float* const beneath[kMostGroundReach], int width, const GroundLimits& limits,
              float* below_m);

}  // namespace predictive_stereo
