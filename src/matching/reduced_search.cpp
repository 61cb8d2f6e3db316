#include "matching/reduced_search.h"

#include <algorithm>

#include "matching/row_visits.h"

namespace predictive_stereo {
namespace {

/// The row that divides the image into two halves of equal work. Work is proportional to the
/// windows.
int rowInTheMiddle(const SearchWindows& windows) {
  const auto work = [&](size_t y) {
    return windows.row_begins[y] + y * windows.width.cols * kNarrowWindow;
  };
  const size_t height = windows.width.rows;
  size_t y = 0;
  while (y < height && 2 * work(y) < work(height)) ++y;
  return static_cast<int>(y);
}

}  // namespace

ReducedSearch::ReducedSearch(const MatcherParams& params, int64_t simd_target)
    : params_(params), simd_target_(simd_target), right_bytes_(simd_target) {}

void ReducedSearch::match(const cv::Mat1i& left_words, const cv::Mat1i& right_words,
                          const PrincipalOffset& offset, const JumpFloors& floors,
                          const SearchWindows& windows, AlignedBuffer& volume, Match& match) {
  const int columns = left_words.cols;
  right_bytes_.build(right_words, offset.columnShifts(params_.range));
  // Room for the widest windows, so that later frames with wider windows need not allocate. Pages
  // that are never touched cost nothing.
  const size_t most = windows.runs.size() * kWindowRun * params_.range.count;
  uint8_t* const all_sums = volume.reserve(kRowSumsMargin + most + kRowSumsMargin) + kRowSumsMargin;
  costs_.reserve(most);

  const int strips = params_.paths == PathSet::kStraight4 ? stripsOfSearch() : 0;
  const int parts = std::max(strips, 1);
  reserve(paths_, 2 * parts, columns);
  searchRows(
      left_words.rows, rowInTheMiddle(windows), strips,
      [&](int y) { return all_sums + windows.row_begins[y]; },
      [&] { return rowWork(columns).row_sums.data() + kRowSumsMargin; },
      [&](const RowTask& task) {
        ReducedSearchRow row = rowOf(task, left_words, floors, windows);
        row.begin_run = windows.runs_per_row * task.strip / parts;
        row.end_run = windows.runs_per_row * (task.strip + 1) / parts;
        reducedSearchRow(simd_target_)(row);
      },
      [&](int y, const uint8_t* sums) {
        chooseWinners(offset, windows, y, sums, rowWork(columns), match);
      });
}

void ReducedSearch::reserve(std::vector<PathRows>& paths, size_t count, int columns) const {
  if (paths.size() < count) paths.resize(count);
  const size_t bytes = static_cast<size_t>(columns + kWindowRun - 1) * params_.range.count;
  for (PathRows& pass : paths)
    for (auto& rows : pass.rows)
      for (AlignedBuffer& row : rows) row.reserve(kBeyond + bytes + kBeyond);
}

ReducedSearch::RowWork& ReducedSearch::rowWork(int columns) {
  RowWork& work = row_works_.local();
  const size_t bytes = static_cast<size_t>(columns + kWindowRun - 1) * params_.range.count;
  work.half_sums.reserve(bytes);
  work.row_sums.reserve(kRowSumsMargin + bytes + kRowSumsMargin);
  work.scratch.resize(columns, params_.range);
  return work;
}

ReducedSearchRow ReducedSearch::rowOf(const RowTask& task, const cv::Mat1i& left_words,
                                      const JumpFloors& floors, const SearchWindows& windows) {
  const int y = task.visit.y;
  const bool upward = task.visit.upward;
  ReducedSearchRow row(SearchRow(params_, task, floors));
  row.columns = windows.width.cols;
  row.left_words = left_words[y];
  row.right_bytes = right_bytes_.row(y);
  row.right_stride = right_bytes_.plane_stride();
  const int previous_y = upward ? y + 1 : y - 1;
  const bool has_previous = previous_y >= 0 && previous_y < windows.width.rows;
  row.windows = windows.row(y);
  row.previous_windows = has_previous ? windows.row(previous_y) : nullptr;
  const PathRows& paths = paths_[2 * task.strip + upward];
  row.previous = paths.states(y & 1);
  row.next = paths.states(~y & 1);
  row.costs = costs_.data() + windows.row_begins[y];
  row.half_sums = task.part == RowPart::kDown ? nullptr : rowWork(row.columns).half_sums.data();
  return row;
}

void ReducedSearch::chooseWinners(const PrincipalOffset& offset, const SearchWindows& windows,
                                  int y, const uint8_t* row_sums, RowWork& work,
                                  Match& match) const {
  WindowSums sums;
  sums.columns = windows.width.cols;
  sums.shifts = offset.columnShifts(params_.range);
  sums.windows = windows.row(y);
  sums.width = windows.width[y];
  sums.sums = row_sums;
  work.winners.resize(windows.width.cols, sums.shifts);
  windowWinners(simd_target_)(sums, work.scratch, work.winners);
  describeRow(work.winners, params_, offset, simd_target_, y, work.winners.first.data(),
              windows.width[y], match);
}

}  // namespace predictive_stereo
