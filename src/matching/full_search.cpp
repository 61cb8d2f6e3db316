#include "matching/full_search.h"

#include <cstring>

#include "matching/striped_winners_kernel.h"
#include "matching/two_passes.h"

namespace predictive_stereo {

FullSearch::FullSearch(const MatcherParams& params, int64_t simd_target)
    : params_(params),
      simd_target_(simd_target),
      layout_(stripedLayout(simd_target, params.range.count)),
      tables_(params.p2),
      left_planes_(params.census, simd_target),
      right_planes_(params.census, simd_target) {
  upward_.upward = true;
  uint8_t* const dead = dead_.reserve(layout_.size());
  for (int i = 0; i < layout_.size(); ++i) {
    const int index = i % layout_.lanes * layout_.vectors + i / layout_.lanes;
    dead[i] = index < params.range.count ? 0 : 255;
  }
}

void FullSearch::match(const cv::Mat1i& left_words, const cv::Mat1i& right_words,
                       const JumpFloors& floors, AlignedBuffer& volume, Match& match) {
  const int width = left_words.cols, height = left_words.rows;
  const size_t row_bytes = static_cast<size_t>(width) * layout_.size();
  left_planes_.buildLeft(left_words);
  right_planes_.buildRight(right_words, {params_.range.min_disparity, layout_.size()},
                           layout_.vectors);
  uint8_t* const all_sums = volume.reserve(row_bytes * height);
  start(downward_, width);
  start(upward_, width);

  visitRowsTwice(height, height / 2, [&](int y, bool upward, bool is_first_visit) {
    Pass& pass = upward ? upward_ : downward_;
    uint8_t* const sums = all_sums + y * row_bytes;
    if (is_first_visit) return aggregateRow(pass, floors, width, y, nullptr, sums);
    aggregateRow(pass, floors, width, y, sums, pass.row_sums.data());
    stripedWinners(simd_target_)({width, params_.range, layout_, pass.row_sums.data()},
                                 pass.winners);
    describeRow(pass.winners, params_, simd_target_, y, nullptr, nullptr, match);
  });
}

void FullSearch::start(Pass& pass, int width) {
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
  pass.row_sums.reserve(bytes);
  pass.winners.resize(width, params_.range);
}

void FullSearch::aggregateRow(Pass& pass, const JumpFloors& floors, int width, int y,
                              const uint8_t* sums_before, uint8_t* sums) {
  FullSearchRow row;
  row.width = width;
  row.layout = layout_;
  row.p1 = params_.p1;
  row.p2 = params_.p2;
  row.nibbles = nibbleCount(params_.census);
  row.paths = params_.paths;
  row.upward = pass.upward;
  row.tables = &tables_;
  row.left_planes = left_planes_.row(y);
  row.left_stride = left_planes_.plane_stride();
  row.right_planes = right_planes_.row(y);
  row.entry_offsets = right_planes_.entry_offsets();
  row.right_stride = right_planes_.plane_stride();
  row.floors_across = floors.across(y);
  row.floors_down = floors.down(pass.upward ? y + 1 : y);
  row.dead = layout_.size() > params_.range.count ? dead_.data() : nullptr;
  row.straight = pass.straight;
  row.from_behind = pass.from_behind;
  row.from_ahead = pass.from_ahead;
  row.sums_before = sums_before;
  row.sums = sums;
  fullSearchRow(simd_target_)(row);
}

}  // namespace predictive_stereo
