/// Reduced search, one row at a time: each run of pixels has its own window of disparities.
///
/// Layout: the costs of a pixel are the bytes of its window, in order; those of a row follow each
/// other (WindowRun::position). A neighbour passes on its goodness (path_step-inl.h), shifted by
/// the distance between the two windows, with zeros outside the neighbour's window: such
/// disparities pay P2 without a branch. Most windows have a width of 16: they are one vector, and
/// the shift is one shuffle.
///
/// Each row is visited twice, by the downward and by the upward pass. With straight paths the first
/// visit follows both horizontal paths, from both ends of the row at once: they do not depend on
/// each other, and share their vectors.
#pragma once

#include <cstddef>
#include <cstdint>

#include "matching/row_visits.h"
#include "matching/search_windows.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Width of the windows that have a fast path.
constexpr int kNarrowWindow = 16;

/// If windows differ, up to this many bytes before and behind those of a pixel may be read.
constexpr int kBeyond = 256 + 64;

/// States of the paths at the previous row, in the layout of its windows.
struct PathStates {
  uint8_t* straight;
  uint8_t* from_behind;  ///< along the diagonal from the previous column of the pass
  uint8_t* from_ahead;   ///< along the diagonal from the next column of the pass
};

/// One row of one pass.
struct ReducedSearchRow : SearchRow {
  explicit ReducedSearchRow(const SearchRow& row) : SearchRow(row) {}

  int columns;
  int begin_run, end_run;  ///< kDown: the runs of this call
  const int* left_words;
  const uint8_t* right_bytes;  ///< CensusBytes of this row
  size_t right_stride;
  const WindowRun* windows;
  const WindowRun* previous_windows;  ///< of the previous row; nullptr: there is none
  PathStates previous, next;
  uint8_t* costs;      ///< matching costs + P2: the first visit writes, the second one reads them
  uint8_t* half_sums;  ///< scratch memory
};

using ReducedSearchRowFunction = void (*)(const ReducedSearchRow&);
ReducedSearchRowFunction reducedSearchRow(int64_t simd_target);

}  // namespace predictive_stereo
