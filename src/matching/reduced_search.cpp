#include "matching/reduced_search.h"

#include "matching/two_passes.h"

namespace predictive_stereo {
namespace {

/// Where the image falls into two halves of equal work, which grows with the windows.
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
    : params_(params), simd_target_(simd_target), right_bytes_(params.census, simd_target) {
  upward_.upward = true;
}

void ReducedSearch::match(const cv::Mat1i& left_words, const cv::Mat1i& right_words,
                          const JumpFloors& floors, const SearchWindows& windows,
                          AlignedBuffer& volume, Match& match) {
  const int height = left_words.rows;
  right_bytes_.build(right_words, params_.range);
  // Room for the widest windows: pages that are never touched cost nothing, and no frame with wider
  // windows than its predecessors has to allocate.
  const size_t most = windows.runs.size() * kWindowRun * params_.range.count;
  uint8_t* const all_sums = volume.reserve(most);
  costs_.reserve(most);
  reserve(downward_, left_words.cols);
  reserve(upward_, left_words.cols);

  visitRowsTwice(height, rowInTheMiddle(windows), [&](int y, bool upward, bool is_first_visit) {
    Pass& pass = upward ? upward_ : downward_;
    uint8_t* const sums = all_sums + windows.row_begins[y];
    if (is_first_visit) return aggregateRow(pass, left_words[y], floors, windows, y, nullptr, sums);
    aggregateRow(pass, left_words[y], floors, windows, y, sums,
                 pass.row_sums.data() + kRowSumsMargin);
    chooseWinners(pass, windows, y, match);
  });
}

void ReducedSearch::reserve(Pass& pass, int columns) {
  const size_t bytes = static_cast<size_t>(columns + kWindowRun - 1) * params_.range.count;
  for (auto& states : pass.states)
    for (AlignedBuffer& state : states) state.reserve(kBeyond + bytes + kBeyond);
  pass.half_sums.reserve(bytes);
  pass.row_sums.reserve(kRowSumsMargin + bytes + kRowSumsMargin);
  pass.scratch.resize(columns, params_.range);
  pass.winners.resize(columns, params_.range);
}

void ReducedSearch::aggregateRow(Pass& pass, const int* left_words, const JumpFloors& floors,
                                 const SearchWindows& windows, int y, const uint8_t* sums_before,
                                 uint8_t* sums) {
  ReducedSearchRow row;
  row.columns = windows.width.cols;
  row.p1 = params_.p1;
  row.p2 = params_.p2;
  row.bytes = censusBytes(params_.census);
  row.paths = params_.paths;
  row.upward = pass.upward;
  row.left_words = left_words;
  row.right_bytes = right_bytes_.row(y);
  row.right_stride = right_bytes_.plane_stride();
  const int previous_y = pass.upward ? y + 1 : y - 1;
  const bool has_previous = previous_y >= 0 && previous_y < windows.width.rows;
  row.floors_across = floors.across(y);
  row.floors_down = floors.down(pass.upward ? y + 1 : y);
  row.windows = windows.row(y);
  row.previous_windows = has_previous ? windows.row(previous_y) : nullptr;
  row.previous = pass.pathStates(y & 1);
  row.next = pass.pathStates(~y & 1);
  row.costs = costs_.data() + windows.row_begins[y];
  row.half_sums = pass.half_sums.data();
  row.sums_before = sums_before;
  row.sums = sums;
  reducedSearchRow(simd_target_)(row);
}

void ReducedSearch::chooseWinners(Pass& pass, const SearchWindows& windows, int y, Match& match) {
  WindowSums sums;
  sums.columns = windows.width.cols;
  sums.range = params_.range;
  sums.windows = windows.row(y);
  sums.width = windows.width[y];
  sums.sums = pass.row_sums.data() + kRowSumsMargin;
  windowWinners(simd_target_)(sums, pass.scratch, pass.winners);
  describeRow(pass.winners, params_, simd_target_, y, pass.winners.first.data(), windows.width[y],
              match);
}

}  // namespace predictive_stereo
