/// The loop of LevelGround over one row of the lattice, compiled for every SIMD target and
/// dispatched at run time. Every target gives the same results, bit by bit.
#pragma once

namespace predictive_stereo {

/// How far up and down disparities are compared: 1, ..., kMostGroundReach lattice rows.
constexpr int kMostGroundReach = 4;

struct GroundLimits {
  float smallest_px;          ///< valid disparities begin here, and above 0
  float reach_by_disparity;   ///< [lattice rows / px]
  float horizon_distance_px;  ///< of the row, positive below
  float baseline_m;
  float least_share, most_share;  ///< of a level surface's growth
};

/// How far below the camera the points of a row are [m] where the disparity grows as on a level
/// surface; 0 elsewhere.
/// @param above, beneath  the rows at distances 1, ... of it; null outside of the map. Of all rows
///   every second float is used.
void levelRow(const float* disparity_px, const float* const above[kMostGroundReach],
              const float* const beneath[kMostGroundReach], int width, const GroundLimits& limits,
              float* below_m);

}  // namespace predictive_stereo
