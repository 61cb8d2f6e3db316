/// Reduced search, one row at a time: each pixel has a window of disparities of its own.
///
/// Layout: the costs of a pixel are the bytes of its window, in order; those of a row lie one after
/// the other. What a neighbour passes on is its goodness (path_step-inl.h), shifted by the distance
/// of the two windows, with zeros where the neighbour's window has nothing: such disparities pay P2
/// without any branch. Windows of 16, by far the most, are one vector, and the shift is one
/// shuffle.
#pragma once

#include <cstddef>
#include <cstdint>

#include "matching/cost_tables.h"
#include "matching/row_winners.h"
#include "matching/search_windows.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Width of the windows that have a fast path.
constexpr int kNarrowWindow = 16;

/// The windows of one row.
struct WindowRow {
  const uint8_t* first;   ///< first index of each pixel
  const uint16_t* width;  ///< a multiple of 16; 0: not searched
  const int* position;    ///< where the pixel's bytes begin in its row's bytes
};

/// What the paths that come from the previous row have left there: bytes as laid out by its
/// windows.
struct PathStates {
  uint8_t* straight;
  uint8_t* from_behind;  ///< along the diagonal from the column that the pass has just left
  uint8_t* from_ahead;   ///< along the diagonal from the column that the pass comes to next
};

/// One row of one pass: the downward pass goes from left to right, the upward one back.
struct ReducedSearchRow {
  int columns;
  int p1, p2;
  int nibbles;
  PathSet paths;
  bool upward;
  const CostTables* tables;
  const uint8_t* left_planes;  ///< CensusPlanes::buildLeft of this row
  size_t left_stride;
  const uint8_t* right_planes;  ///< CensusPlanes::buildRight of this row, with one phase
  size_t right_stride;
  WindowRow windows;
  WindowRow previous_windows;  ///< of the row before; members are nullptr: there is none
  PathStates previous, next;
  /// Matching costs of windows of 16, [x][16]: left by the first pass for the second one.
  uint8_t* narrow_costs;
  const uint8_t* sums_before;  ///< sums of the other pass, or nullptr
  uint8_t* sums;
};

using ReducedSearchRowFunction = void (*)(const ReducedSearchRow&);
ReducedSearchRowFunction reducedSearchRow(int64_t simd_target);

}  // namespace predictive_stereo
