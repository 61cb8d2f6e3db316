#include "matching/reduced_search.h"

#include "matching/window_winners_kernel.h"

namespace predictive_stereo {

ReducedSearch::ReducedSearch(const MatcherParams& params, int64_t simd_target)
    : params_(params),
      simd_target_(simd_target),
      tables_(params.p2),
      left_planes_(params.census, simd_target),
      right_planes_(params.census, simd_target) {
  upward_.upward = true;
}

void ReducedSearch::match(const cv::Mat1i& left_words, const cv::Mat1i& right_words,
                          const SearchWindows& windows, AlignedBuffer& volume, Match& match) {
  const int height = left_words.rows;
  left_planes_.buildLeft(left_words);
  right_planes_.buildRight(right_words, params_.range, 1);
  layOut(windows);
  // Room for the widest windows: pages that are never touched cost nothing, and no frame with wider
  // windows than its predecessors has to allocate.
  uint8_t* const all_sums = volume.reserve(left_words.total() * params_.range.count);
  narrow_costs_.reserve(left_words.total() * kNarrowWindow);
  reserve(downward_, left_words.cols);
  reserve(upward_, left_words.cols);

  const int middle = height / 2;
  const auto runHalf = [&](bool first_half_of_pass, bool top) {
    Pass& pass = first_half_of_pass == top ? downward_ : upward_;
    const int begin = top ? 0 : middle, end = top ? middle : height;
    for (int i = begin; i < end; ++i) {
      const int y = pass.upward ? begin + end - 1 - i : i;
      uint8_t* const sums = all_sums + row_begins_[y];
      if (first_half_of_pass) {
        aggregateRow(pass, windows, y, nullptr, sums);
      } else {
        aggregateRow(pass, windows, y, sums, pass.row_sums.data());
        chooseWinners(pass, windows, y, match);
      }
    }
  };
  for (const bool first_half_of_pass : {true, false})
    cv::parallel_for_(cv::Range(0, 2), [&](const cv::Range& halves) {
      for (int half = halves.start; half < halves.end; ++half)
        runHalf(first_half_of_pass, half == 0);
    });
}

size_t ReducedSearch::layOut(const SearchWindows& windows) {
  const cv::Size size = windows.width.size();
  positions_.create(size);
  row_begins_.resize(size.height + 1);
  row_begins_[0] = 0;
  for (int y = 0; y < size.height; ++y) {
    const uint16_t* width = windows.width[y];
    int* positions = positions_[y];
    int position = 0;
    for (int x = 0; x < size.width; ++x) {
      positions[x] = position;
      position += width[x];
    }
    row_begins_[y + 1] = row_begins_[y] + position;
  }
  return row_begins_.back();
}

WindowRow ReducedSearch::windowRow(const SearchWindows& windows, int y) const {
  if (y < 0 || y >= windows.width.rows) return {nullptr, nullptr, nullptr};
  return {windows.first[y], windows.width[y], positions_[y]};
}

void ReducedSearch::reserve(Pass& pass, int columns) {
  const size_t bytes = static_cast<size_t>(columns) * params_.range.count;
  for (auto& states : pass.states)
    for (AlignedBuffer& state : states) state.reserve(bytes);
  pass.row_sums.reserve(bytes);
  pass.right_scratch.reserve((columns + params_.range.count + 16) * sizeof(uint16_t));
  pass.winners.resize(columns, params_.range);
}

void ReducedSearch::aggregateRow(Pass& pass, const SearchWindows& windows, int y,
                                 const uint8_t* sums_before, uint8_t* sums) {
  ReducedSearchRow row;
  row.columns = windows.width.cols;
  row.p1 = params_.p1;
  row.p2 = params_.p2;
  row.nibbles = nibbleCount(params_.census);
  row.paths = params_.paths;
  row.upward = pass.upward;
  row.tables = &tables_;
  row.left_planes = left_planes_.row(y);
  row.left_stride = left_planes_.plane_stride();
  row.right_planes = right_planes_.row(y);
  row.right_stride = right_planes_.plane_stride();
  row.windows = windowRow(windows, y);
  row.previous_windows = windowRow(windows, pass.upward ? y + 1 : y - 1);
  row.previous = pass.pathStates(y & 1);
  row.next = pass.pathStates(~y & 1);
  row.narrow_costs = narrow_costs_.data() + static_cast<size_t>(y) * row.columns * kNarrowWindow;
  row.sums_before = sums_before;
  row.sums = sums;
  reducedSearchRow(simd_target_)(row);
}

void ReducedSearch::chooseWinners(Pass& pass, const SearchWindows& windows, int y, Match& match) {
  WindowSums sums;
  sums.columns = windows.width.cols;
  sums.range = params_.range;
  sums.windows = windowRow(windows, y);
  sums.sums = pass.row_sums.data();
  sums.right_scratch = reinterpret_cast<uint16_t*>(pass.right_scratch.data());
  windowWinners(simd_target_)(sums, pass.winners);
  describeRow(pass.winners, params_, simd_target_, y, windows.first[y], windows.width[y], match);
}

}  // namespace predictive_stereo
