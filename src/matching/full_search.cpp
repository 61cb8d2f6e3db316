#include "matching/full_search.h"

#include <algorithm>
#include <cstring>

#include "matching/row_visits.h"
#include "matching/row_winners.h"

namespace predictive_stereo {

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

}  // namespace predictive_stereo
