/// Reduced search of a pair by kernels: as FullSearch, with windows.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "matching/aligned_buffer.h"
#include "matching/census_planes.h"
#include "matching/cost_tables.h"
#include "matching/reduced_kernel.h"
#include "matching/row_winners.h"
#include "matching/search_windows.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

class ReducedSearch {
 public:
  ReducedSearch(const MatcherParams& params, int64_t simd_target);

  /// Fills every member of `match` except search_width; all have their sizes already.
  /// @param volume  memory for the sums of all windows; may be shared with other searches.
  void match(const cv::Mat1i& left_words, const cv::Mat1i& right_words,
             const SearchWindows& windows, AlignedBuffer& volume, Match& match);

 private:
  struct Pass {
    bool upward = false;
    /// Goodness of the three paths that come from the previous row, before and after a row.
    AlignedBuffer states[2][3];
    AlignedBuffer row_sums;
    AlignedBuffer right_scratch;
    RowWinners winners;

    PathStates pathStates(int which) const {
      return {states[which][0].data(), states[which][1].data(), states[which][2].data()};
    }
  };

  size_t layOut(const SearchWindows& windows);
  WindowRow windowRow(const SearchWindows& windows, int y) const;
  void reserve(Pass& pass, int columns);
  void aggregateRow(Pass& pass, const SearchWindows& windows, int y, const uint8_t* sums_before,
                    uint8_t* sums);
  void chooseWinners(Pass& pass, const SearchWindows& windows, int y, Match& match);

  const MatcherParams params_;
  const int64_t simd_target_;
  const CostTables tables_;
  CensusPlanes left_planes_, right_planes_;
  AlignedBuffer narrow_costs_;
  cv::Mat1i positions_;             ///< of each pixel's bytes in its row's bytes
  std::vector<size_t> row_begins_;  ///< of each row's bytes in the volume, and the volume's size
  Pass downward_, upward_;
};

}  // namespace predictive_stereo
