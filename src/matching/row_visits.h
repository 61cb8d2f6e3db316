/// The order in which the passes of a search visit the rows of an image, and what they do there.
#pragma once

#include <algorithm>
#include <cstdint>
#include <opencv2/core/utility.hpp>

#include "matching/jump_floors.h"
#include "parallel/tasks.h"

namespace predictive_stereo {

/// The part of a row's work that one visit does. Horizontal paths need no other row, and vertical
/// paths no other column: rows and columns can therefore be distributed over threads.
enum class RowPart {
  kWhole,   ///< all paths of the pass
  kAcross,  ///< both horizontal paths
  kDown,    ///< the vertical path of the pass, in a strip of columns
};

/// A downward and an upward pass visit every row, both at the same time. The downward pass starts
/// at the top, the upward one at the bottom; they meet before row `middle` and continue in the rows
/// of the other one. Each pass keeps its order of rows, so the result is exact.
struct RowVisit {
  int y;
  bool upward;
  bool is_first;  ///< of the two visits to this row
  int slot = 0;   ///< by strips: number of the row in its chunk; below kChunkSlots
};

constexpr int kChunkRows = 32;  ///< of each pass; their output stays in the caches
constexpr int kChunkSlots = 2 * kChunkRows;

/// For two threads: one for each pass.
/// @param visit_row  called with a RowVisit.
template <class VisitRow>
void visitRowsTwice(int height, int middle, const VisitRow& visit_row) {
  for (const bool is_first : {true, false})
    parallelForEach(2, [&](int half) {
      const bool is_top = half == 0, upward = is_top != is_first;
      const int begin = is_top ? 0 : middle, end = is_top ? middle : height;
      for (int i = begin; i < end; ++i)
        visit_row(RowVisit{upward ? begin + end - 1 - i : i, upward, is_first});
    });
}

/// For any number of threads: chunks of rows of both passes. Work within a row is distributed by
/// rows, vertical paths by strips of columns.
/// @param across  called with a RowVisit, once a row, before any other.
/// @param down  called with (RowVisit, strip) for each strip from 0 to `strips` - 1.
/// @param finish  called with a RowVisit, once a row, after all others.
template <class Across, class Down, class Finish>
void visitRowsByStrips(int height, int middle, int strips, const Across& across, const Down& down,
                       const Finish& finish) {
  const int begins[] = {0, middle}, ends[] = {middle, height};
  for (const bool is_first : {true, false})
    for (int chunk = 0; chunk < std::max(middle, height - middle); chunk += kChunkRows) {
      const auto visitOf = [&](int half, int i) {
        const bool upward = (half == 0) != is_first;
        return RowVisit{upward ? ends[half] - 1 - i : begins[half] + i, upward, is_first,
                        2 * (i % kChunkRows) + half};
      };
      const auto rowsLeft = [&](int half) {
        return std::clamp(ends[half] - begins[half] - chunk, 0, kChunkRows);
      };
      const auto forEachRow = [&](const auto& visit_row) {
        parallelForEach(kChunkSlots, [&](int row) {
          if (row / 2 < rowsLeft(row % 2)) visit_row(visitOf(row % 2, chunk + row / 2));
        });
      };
      if (is_first) forEachRow(across);
      parallelForEach(2 * strips, [&](int part) {
        for (int i = 0; i < rowsLeft(part % 2); ++i) down(visitOf(part % 2, chunk + i), part / 2);
      });
      if (!is_first) forEachRow(finish);
    }
}

/// What one call of a kernel does.
struct RowTask {
  RowVisit visit;
  RowPart part;
  int strip;                   ///< of kDown
  const uint8_t* sums_before;  ///< sums of earlier visits; nullptr: kWhole, the first visit
  uint8_t* sums;               ///< the same memory unless kWhole; kAcross does not read it before
};

/// Both visits to all rows, in one of these ways, and the choice of their winners.
/// @param strips  0: for two threads.
/// @param sums_of  called with y; memory for the sums of the row, from visit to visit.
/// @param scratch_sums  memory of this thread for the sums of any row.
/// @param visit_row  called with a RowTask.
/// @param choose_winners  called with y and the sums of all visits to the row.
template <class SumsOf, class ScratchSums, class VisitRow, class ChooseWinners>
void searchRows(int height, int middle, int strips, const SumsOf& sums_of,
                const ScratchSums& scratch_sums, const VisitRow& visit_row,
                const ChooseWinners& choose_winners) {
  if (strips == 0)
    return visitRowsTwice(height, middle, [&](const RowVisit& visit) {
      uint8_t* const between = sums_of(visit.y);
      if (visit.is_first) return visit_row(RowTask{visit, RowPart::kWhole, 0, nullptr, between});
      uint8_t* const sums = scratch_sums();
      visit_row(RowTask{visit, RowPart::kWhole, 0, between, sums});
      choose_winners(visit.y, sums);
    });
  const auto visitPart = [&](const RowVisit& visit, RowPart part, int strip) {
    uint8_t* const sums = sums_of(visit.y);
    visit_row(RowTask{visit, part, strip, sums, sums});
  };
  visitRowsByStrips(
      height, middle, strips, [&](const RowVisit& visit) { visitPart(visit, RowPart::kAcross, 0); },
      [&](const RowVisit& visit, int strip) { visitPart(visit, RowPart::kDown, strip); },
      [&](const RowVisit& visit) { choose_winners(visit.y, sums_of(visit.y)); });
}

/// What the kernels of both searches are told of a row. The downward pass goes from left to right
/// and follows the paths from the left and from above; the upward pass is its mirror image.
struct SearchRow {
  SearchRow(const MatcherParams& params, const RowTask& task, const JumpFloors& floors)
      : p1(params.p1),
        p2(params.p2),
        paths(params.paths),
        upward(task.visit.upward),
        part(task.part),
        floors_across(floors.across(task.visit.y)),
        floors_down(floors.down(task.visit.upward ? task.visit.y + 1 : task.visit.y)),
        sums_before(task.sums_before),
        sums(task.sums) {}

  int p1, p2;
  PathSet paths;
  bool upward;
  RowPart part;                  ///< kWhole unless paths are straight
  const uint8_t* floors_across;  ///< JumpFloors of this row
  const uint8_t* floors_down;    ///< JumpFloors between the previous row of the pass and this one
  const uint8_t* sums_before;    ///< as in RowTask
  uint8_t* sums;
};

/// Number of strips for each pass, or 0 if each pass is done by one thread, which is as fast with
/// two threads. More strips than threads, as the windows of strips differ in width.
inline int stripsOfSearch() { return cv::getNumThreads() > 2 ? 2 * cv::getNumThreads() : 0; }

}  // namespace predictive_stereo
