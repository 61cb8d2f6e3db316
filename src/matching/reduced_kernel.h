/// Reduced search, one row at a time: each run of pixels has a window of disparities of its own.
///
/// Layout: the costs of a pixel are the bytes of its window, in order; those of a row lie one after
/// the other (WindowRun::position). What a neighbour passes on is its goodness (path_step-inl.h),
/// shifted by the distance of the two windows, with zeros where the neighbour's window has nothing:
/// such disparities pay P2 without any branch. Windows of 16, by far the most, are one vector, and
/// the shift is one shuffle.
///
/// Each row is visited twice, by the downward and by the upward pass. With straight paths both
/// horizontal ones belong to the first visit, which walks from both ends of the row at once: they
/// do not wait for each other, and share their vectors.
#pragma once

#include <cstddef>
#include <cstdint>

#include "matching/row_visits.h"
#include "matching/search_windows.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Width of the windows that have a fast path.
constexpr int kNarrowWindow = 16;

/// Where windows differ, up to that many bytes before and behind a pixel's may be read.
constexpr int kBeyond = 256 + 64;

/// What the paths that come from the previous row have left there: bytes as laid out by its
/// windows.
struct PathStates {
  uint8_t* straight;
  uint8_t* from_behind;  ///< along the diagonal from the column that the pass has just left
  uint8_t* from_ahead;   ///< along the diagonal from the column that the pass comes to next
};

/// One row of one pass. The downward pass goes from left to right, the upward one back.
struct ReducedSearchRow {
  int columns;
  int p1, p2;
  int bytes;  ///< of a census word
  PathSet paths;
  bool upward;
  RowPart part;            ///< of straight paths alone; others: kWhole
  int begin_run, end_run;  ///< kDown: where
  const int* left_words;
  const uint8_t* right_bytes;  ///< CensusBytes of this row
  size_t right_stride;
  const uint8_t* floors_across;  ///< JumpFloors of this row
  const uint8_t* floors_down;    ///< JumpFloors between this row and the row before
  const WindowRun* windows;
  const WindowRun* previous_windows;  ///< of the row before; nullptr: there is none
  PathStates previous, next;
  uint8_t* costs;      ///< matching costs + P2: left by the first visit for the second one
  uint8_t* half_sums;  ///< scratch memory
  /// Sums of earlier visits, or nullptr; of kDown they may be `sums`.
  const uint8_t* sums_before;
  uint8_t* sums;
};

using ReducedSearchRowFunction = void (*)(const ReducedSearchRow&);
ReducedSearchRowFunction reducedSearchRow(int64_t simd_target);

}  // namespace predictive_stereo
