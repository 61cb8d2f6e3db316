/// Full search, one row at a time: every disparity of every pixel, in vectors of 8-bit costs.
///
/// Layout ("striped"): the costs of a pixel are in K vectors of N lanes; lane i of vector k belongs
/// to disparity index i * K + k. The neighbours d +- 1 of vector k are then the vectors k +- 1,
/// except for the first and the last vector. Indices from `count` on are dead: they cost 255.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>

#include "matching/row_visits.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

struct StripedLayout {
  int lanes;    ///< N, of the target's vectors
  int vectors;  ///< K

  int size() const { return lanes * vectors; }  ///< bytes per pixel
};
/// The smallest layout of this target that holds `count` disparities.
StripedLayout stripedLayout(int64_t simd_target, int count);

/// Hamming distances of census words. Each value of four bits of the left word has a row of 16
/// distances, one for each value of the four bits of the right word. A byte shuffle with this row
/// gives the distances of 16 or more right pixels at once, without a population count.
struct CostTables {
  explicit CostTables(int p2) {
    for (unsigned left = 0; left < 16; ++left)
      for (unsigned right = 0; right < 16; ++right) {
        const unsigned at = 16 * left + right;
        distance[at] = static_cast<uint8_t>(std::bitset<4>(left ^ right).count());
        distance_and_p2[at] = static_cast<uint8_t>(distance[at] + p2);
      }
  }

  // Row after row. The planes of the left image hold the positions where rows begin.
  alignas(64) uint8_t distance[16 * 16];
  alignas(64) uint8_t distance_and_p2[16 * 16];  ///< P2 included, for the first four bits of a word
};

/// State of a path at the pixels of a row: its costs L, [x][StripedLayout::size()], and P2 + the
/// lowest cost of each pixel, [x].
struct PathRow {
  uint8_t* costs;
  uint8_t* most;
};

/// One row of one pass.
struct FullSearchRow : SearchRow {
  explicit FullSearchRow(const SearchRow& row) : SearchRow(row) {}

  int width;
  StripedLayout layout;
  int begin_column, end_column;  ///< kDown: the columns of this call
  const CostTables* tables;
  const uint8_t* left_planes;  ///< CensusPlanes::buildLeft of this row
  size_t left_stride;
  const uint8_t* right_planes;  ///< CensusPlanes::buildRight of this row, with K phases
  size_t right_stride;
  const uint32_t* entry_offsets;
  const uint8_t* dead;  ///< 255 at dead indices, 0 at others; nullptr: none is dead
  /// Paths at the previous row, replaced by those at this row: the vertical one and both diagonals.
  PathRow straight;
  PathRow from_behind;  ///< along the diagonal from the previous column of the pass
  PathRow from_ahead;   ///< along the diagonal from the next column of the pass
  /// Matching costs + P2 of the row: kAcross writes them, kDown reads them; nullptr: kDown computes
  /// them again. kWhole does not use them. As the sums, [x][StripedLayout::size()].
  uint8_t* costs;
};

using FullSearchRowFunction = void (*)(const FullSearchRow&);
FullSearchRowFunction fullSearchRow(int64_t simd_target);

}  // namespace predictive_stereo
