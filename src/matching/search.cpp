#include "matching/search.h"

#include <algorithm>
#include <cstring>

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

FullSearch::FullSearch(const MatcherParams& params, int64_t simd_target)
    : params_(params),
      simd_target_(simd_target),
      layout_(stripedLayout(simd_target, params.range.count)),
      tables_(params.p2),
      left_planes_(simd_target),
      right_planes_(simd_target) {
  uint8_t* const dead = dead_.reserve(layout_.size());
  for (int i = 0; i < layout_.size(); ++i) {
    const int index = i % layout_.lanes * layout_.vectors + i / layout_.lanes;
    dead[i] = index < params.range.count ? 0 : 255;
  }
}

void FullSearch::match(const cv::Mat1i& left_words, const cv::Mat1i& right_words,
                       const PrincipalOffset& offset, const JumpFloors& floors,
                       AlignedBuffer& volume, Match& match) {
  const int width = left_words.cols, height = left_words.rows;
  const size_t row_bytes = static_cast<size_t>(width) * layout_.size();
  left_planes_.buildLeft(left_words);
  right_planes_.buildRight(right_words,
                           {offset.columnShifts(params_.range).min_disparity, layout_.size()},
                           layout_.vectors);
  uint8_t* const all_sums = volume.reserve(row_bytes * height);
  start(downward_, width);
  start(upward_, width);

  const int strips = params_.paths == PathSet::kStraight4 ? stripsOfSearch() : 0;
  const int parts = std::max(strips, 1);
  uint8_t* const chunk_costs = strips > 0 ? chunk_costs_.reserve(row_bytes * kChunkSlots) : nullptr;
  searchRows(
      height, height / 2, strips, [&](int y) { return all_sums + y * row_bytes; },
      [&] { return row_works_.local().sums.reserve(row_bytes); },
      [&](const RowTask& task) {
        FullSearchRow row = rowOf(task, floors, width);
        row.begin_column = width * task.strip / parts;
        row.end_column = width * (task.strip + 1) / parts;
        const bool keeps_costs = strips > 0 && task.visit.is_first;
        row.costs = keeps_costs ? chunk_costs + task.visit.slot * row_bytes : nullptr;
        fullSearchRow(simd_target_)(row);
      },
      [&](int y, const uint8_t* sums) {
        chooseWinners(offset, y, sums, row_works_.local().winners, match);
      });
}

void FullSearch::chooseWinners(const PrincipalOffset& offset, int y, const uint8_t* sums,
                               RowWinners& winners, Match& match) const {
  const int width = match.disparity_px.cols;
  const DisparityRange shifts = offset.columnShifts(params_.range);
  winners.resize(width, shifts);
  stripedWinners(simd_target_)({width, shifts, layout_, sums}, winners);
  describeRow(winners, params_, offset, simd_target_, y, nullptr, nullptr, match);
}

void FullSearch::start(Pass& pass, int width) const {
  const size_t bytes = static_cast<size_t>(width) * layout_.size();
  uint8_t* memory = pass.paths.reserve(3 * (bytes + width));
  for (PathRow* path : {&pass.straight, &pass.from_behind, &pass.from_ahead}) {
    path->costs = memory;
    std::memset(path->costs, 0, bytes);
    memory += bytes;
  }
  for (PathRow* path : {&pass.straight, &pass.from_behind, &pass.from_ahead}) {
    path->most = memory;
    std::memset(path->most, params_.p2, width);
    memory += width;
  }
}

FullSearchRow FullSearch::rowOf(const RowTask& task, const JumpFloors& floors, int width) const {
  const int y = task.visit.y;
  const Pass& pass = task.visit.upward ? upward_ : downward_;
  FullSearchRow row(SearchRow(params_, task, floors));
  row.width = width;
  row.layout = layout_;
  row.tables = &tables_;
  row.left_planes = left_planes_.row(y);
  row.left_stride = left_planes_.plane_stride();
  row.right_planes = right_planes_.row(y);
  row.entry_offsets = right_planes_.entry_offsets();
  row.right_stride = right_planes_.plane_stride();
  row.dead = layout_.size() > params_.range.count ? dead_.data() : nullptr;
  row.straight = pass.straight;
  row.from_behind = pass.from_behind;
  row.from_ahead = pass.from_ahead;
  return row;
}

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
