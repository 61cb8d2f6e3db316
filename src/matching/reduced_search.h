/// Reduced search of a pair by kernels: as FullSearch, with windows.
#pragma once

#include <opencv2/core.hpp>

#include "matching/aligned_buffer.h"
#include "matching/census_bytes.h"
#include "matching/jump_floors.h"
#include "matching/reduced_kernel.h"
#include "matching/row_winners.h"
#include "matching/search_windows.h"
#include "matching/window_winners_kernel.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

class ReducedSearch {
 public:
  ReducedSearch(const MatcherParams& params, int64_t simd_target);

  /// Fills every member of `match` except search_width; all have their sizes already.
  /// @param volume  memory for the sums of all windows; may be shared with other searches.
  void match(const cv::Mat1i& left_words, const cv::Mat1i& right_words, const JumpFloors& floors,
             const SearchWindows& windows, AlignedBuffer& volume, Match& match);

 private:
  struct Pass {
    bool upward = false;
    /// Goodness of the three paths that come from the previous row, before and after a row.
    AlignedBuffer states[2][3];
    AlignedBuffer row_sums;  ///< of the row at hand, behind a margin
    AlignedBuffer half_sums;
    WindowWinnersScratch scratch;
    RowWinners winners;

    PathStates pathStates(int which) const {
      return {states[which][0].data() + kBeyond, states[which][1].data() + kBeyond,
              states[which][2].data() + kBeyond};
    }
  };

  void reserve(Pass& pass, int columns);
  void aggregateRow(Pass& pass, const int* left_words, const JumpFloors& floors,
                    const SearchWindows& windows, int y, const uint8_t* sums_before, uint8_t* sums);
  void chooseWinners(Pass& pass, const SearchWindows& windows, int y, Match& match);

  const MatcherParams params_;
  const int64_t simd_target_;
  CensusBytes right_bytes_;
  AlignedBuffer costs_;
  Pass downward_, upward_;
};

}  // namespace predictive_stereo
