/// Full search of a pair by kernels: both passes, each exactly, on two threads.
#pragma once

#include <opencv2/core.hpp>

#include "matching/aligned_buffer.h"
#include "matching/census_planes.h"
#include "matching/cost_tables.h"
#include "matching/full_kernel.h"
#include "matching/jump_floors.h"
#include "matching/row_winners.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// The paths of the downward pass need the rows above, those of the upward pass the rows below. So
/// each pass starts on its own half of the image and leaves its sums there; then they swap halves,
/// add what the other one has left, and choose winners.
class FullSearch {
 public:
  FullSearch(const MatcherParams& params, int64_t simd_target);

  /// Fills every member of `match` except search_width; all have their sizes already.
  /// @param volume  memory for the sums of all disparities; may be shared with other searches.
  void match(const cv::Mat1i& left_words, const cv::Mat1i& right_words, const JumpFloors& floors,
             AlignedBuffer& volume, Match& match);

 private:
  struct Pass {
    bool upward = false;
    AlignedBuffer paths;
    PathRow straight, from_behind, from_ahead;
    AlignedBuffer row_sums;
    RowWinners winners;
  };

  void start(Pass& pass, int width);
  void aggregateRow(Pass& pass, const JumpFloors& floors, int width, int y,
                    const uint8_t* sums_before, uint8_t* sums);

  const MatcherParams params_;
  const int64_t simd_target_;
  const StripedLayout layout_;
  const CostTables tables_;
  AlignedBuffer dead_;
  CensusPlanes left_planes_, right_planes_;
  Pass downward_, upward_;
};

}  // namespace predictive_stereo
