#include "matching/full_search.h"

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
  if (strips > 0) return matchByStrips(offset, floors, strips, all_sums, match);
  visitRowsTwice(height, height / 2, [&](const RowVisit& visit) {
    RowWork& work = row_works_.local();
    uint8_t* const sums = all_sums + visit.y * row_bytes;
    uint8_t* const row_sums = work.sums.reserve(row_bytes);
    fullSearchRow(simd_target_)(rowOf(visit, RowPart::kWhole, floors, width,
                                      visit.is_first ? nullptr : sums,
                                      visit.is_first ? sums : row_sums));
    if (!visit.is_first) chooseWinners(offset, visit.y, row_sums, work.winners, match);
  });
}

void FullSearch::matchByStrips(const PrincipalOffset& offset, const JumpFloors& floors, int strips,
                               uint8_t* all_sums, Match& match) {
  const int width = match.disparity_px.cols, height = match.disparity_px.rows;
  const size_t row_bytes = static_cast<size_t>(width) * layout_.size();
  uint8_t* const chunk_costs = chunk_costs_.reserve(row_bytes * kChunkSlots);
  const auto rowOfStrips = [&](const RowVisit& visit, RowPart part) {
    uint8_t* const sums = all_sums + visit.y * row_bytes;
    FullSearchRow row = rowOf(visit, part, floors, width, sums, sums);
    if (visit.is_first) row.costs = chunk_costs + visit.slot * row_bytes;
    return row;
  };
  const auto across = [&](const RowVisit& visit) {
    fullSearchRow(simd_target_)(rowOfStrips(visit, RowPart::kAcross));
  };
  const auto down = [&](const RowVisit& visit, int strip) {
    FullSearchRow row = rowOfStrips(visit, RowPart::kDown);
    row.begin_column = width * strip / strips;
    row.end_column = width * (strip + 1) / strips;
    fullSearchRow(simd_target_)(row);
  };
  const auto finish = [&](const RowVisit& visit) {
    const uint8_t* const sums = all_sums + visit.y * row_bytes;
    chooseWinners(offset, visit.y, sums, row_works_.local().winners, match);
  };
  visitRowsByStrips(height, height / 2, strips, across, down, finish);
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

FullSearchRow FullSearch::rowOf(const RowVisit& visit, RowPart part, const JumpFloors& floors,
                                int width, const uint8_t* sums_before, uint8_t* sums) const {
  const int y = visit.y;
  const Pass& pass = visit.upward ? upward_ : downward_;
  FullSearchRow row;
  row.width = width;
  row.layout = layout_;
  row.p1 = params_.p1;
  row.p2 = params_.p2;
  row.paths = params_.paths;
  row.upward = visit.upward;
  row.part = part;
  row.begin_column = 0;
  row.end_column = width;
  row.tables = &tables_;
  row.left_planes = left_planes_.row(y);
  row.left_stride = left_planes_.plane_stride();
  row.right_planes = right_planes_.row(y);
  row.entry_offsets = right_planes_.entry_offsets();
  row.right_stride = right_planes_.plane_stride();
  row.floors_across = floors.across(y);
  row.floors_down = floors.down(visit.upward ? y + 1 : y);
  row.dead = layout_.size() > params_.range.count ? dead_.data() : nullptr;
  row.straight = pass.straight;
  row.from_behind = pass.from_behind;
  row.from_ahead = pass.from_ahead;
  row.costs = nullptr;
  row.sums_before = sums_before;
  row.sums = sums;
  return row;
}

}  // namespace predictive_stereo
