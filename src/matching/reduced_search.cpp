#include "matching/reduced_search.h"

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
  if (strips > 0)
    return matchByStrips(left_words, offset, floors, windows, strips, all_sums, match);
  reserve(paths_, 2, columns);
  visitRowsTwice(left_words.rows, rowInTheMiddle(windows), [&](const RowVisit& visit) {
    RowWork& work = rowWork(columns);
    uint8_t* const sums = all_sums + windows.row_begins[visit.y];
    uint8_t* const row_sums = work.row_sums.data() + kRowSumsMargin;
    const RowMemory memory{&paths_[visit.upward], work.half_sums.data(),
                           visit.is_first ? nullptr : sums, visit.is_first ? sums : row_sums};
    reducedSearchRow(simd_target_)(
        rowOf(visit, RowPart::kWhole, left_words, floors, windows, memory));
    if (!visit.is_first) chooseWinners(offset, windows, visit.y, row_sums, work, match);
  });
}

void ReducedSearch::matchByStrips(const cv::Mat1i& left_words, const PrincipalOffset& offset,
                                  const JumpFloors& floors, const SearchWindows& windows,
                                  int strips, uint8_t* all_sums, Match& match) {
  const int columns = left_words.cols;
  reserve(paths_, 2 * strips, columns);
  const auto across = [&](const RowVisit& visit) {
    uint8_t* const sums = all_sums + windows.row_begins[visit.y];
    const RowMemory memory{&paths_[0], rowWork(columns).half_sums.data(), nullptr, sums};
    reducedSearchRow(simd_target_)(
        rowOf(visit, RowPart::kAcross, left_words, floors, windows, memory));
  };
  const auto down = [&](const RowVisit& visit, int strip) {
    uint8_t* const sums = all_sums + windows.row_begins[visit.y];
    const RowMemory memory{&paths_[2 * strip + visit.upward], nullptr, sums, sums};
    ReducedSearchRow row = rowOf(visit, RowPart::kDown, left_words, floors, windows, memory);
    row.begin_run = windows.runs_per_row * strip / strips;
    row.end_run = windows.runs_per_row * (strip + 1) / strips;
    reducedSearchRow(simd_target_)(row);
  };
  const auto finish = [&](const RowVisit& visit) {
    chooseWinners(offset, windows, visit.y, all_sums + windows.row_begins[visit.y],
                  rowWork(columns), match);
  };
  visitRowsByStrips(left_words.rows, rowInTheMiddle(windows), strips, across, down, finish);
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

ReducedSearchRow ReducedSearch::rowOf(const RowVisit& visit, RowPart part,
                                      const cv::Mat1i& left_words, const JumpFloors& floors,
                                      const SearchWindows& windows, const RowMemory& memory) const {
  const int y = visit.y;
  ReducedSearchRow row;
  row.columns = windows.width.cols;
  row.p1 = params_.p1;
  row.p2 = params_.p2;
  row.paths = params_.paths;
  row.upward = visit.upward;
  row.part = part;
  row.begin_run = 0;
  row.end_run = windows.runs_per_row;
  row.left_words = left_words[y];
  row.right_bytes = right_bytes_.row(y);
  row.right_stride = right_bytes_.plane_stride();
  const int previous_y = visit.upward ? y + 1 : y - 1;
  const bool has_previous = previous_y >= 0 && previous_y < windows.width.rows;
  row.floors_across = floors.across(y);
  row.floors_down = floors.down(visit.upward ? y + 1 : y);
  row.windows = windows.row(y);
  row.previous_windows = has_previous ? windows.row(previous_y) : nullptr;
  row.previous = memory.paths->states(y & 1);
  row.next = memory.paths->states(~y & 1);
  row.costs = costs_.data() + windows.row_begins[y];
  row.half_sums = memory.half_sums;
  row.sums_before = memory.sums_before;
  row.sums = memory.sums;
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
