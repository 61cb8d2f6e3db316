/// Full search, one row at a time: every disparity of every pixel, in vectors of 8-bit costs.
///
/// Layout ("striped"): the costs of a pixel lie in `count` bytes, as K = count / N vectors of N
/// lanes, lane i of vector k belonging to disparity index i * K + k. The neighbours d +- 1 of
/// vector k are then simply the vectors k +- 1, but for the two at the ends.
#pragma once

#include <cstddef>
#include <cstdint>

#include "matching/cost_tables.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Lanes N of the layout for this many disparities on this target.
int fullSearchLanes(int64_t simd_target, int count);

/// One row of one pass. The downward pass goes from left to right and carries the paths that come
/// from the left and from above; the upward pass is its mirror image.
struct FullSearchRow {
  int width;
  int count;
  int p1, p2;
  int nibbles;
  PathSet paths;
  bool upward;
  const CostTables* tables;
  const uint8_t* left_planes;  ///< CensusPlanes::buildLeft of this row
  size_t left_stride;
  const uint8_t* right_planes;  ///< CensusPlanes::buildRight of this row, with K phases
  size_t right_stride;
  const uint32_t* entry_offsets;
  /// Goodness at the previous row, replaced by that of this one: [x][count]. Paths that come
  /// straight, and along both diagonals.
  uint8_t* straight;
  uint8_t* from_behind;        ///< from the column that the pass has just left
  uint8_t* from_ahead;         ///< from the column that the pass comes to next
  const uint8_t* sums_before;  ///< sums of the other pass, or nullptr
  uint8_t* sums;               ///< [x][count]
};

using FullSearchRowFunction = void (*)(const FullSearchRow&);
FullSearchRowFunction fullSearchRow(int64_t simd_target);

}  // namespace predictive_stereo
