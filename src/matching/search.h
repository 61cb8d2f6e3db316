/// Full and reduced search of a pair by kernels, exact for any number of threads.
///
/// The paths of the downward pass need the rows above, those of the upward pass the rows below.
/// Therefore each pass starts on its own half of the image and stores its sums there. Then they
/// swap halves, add the sums of the other pass, and choose the winners.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <opencv2/core.hpp>
#include <vector>

#include "matching/aligned_buffer.h"
#include "matching/census.h"
#include "matching/full_kernel.h"
#include "matching/jump_floors.h"
#include "matching/principal_offset.h"
#include "matching/reduced_kernel.h"
#include "matching/row_winners.h"
#include "matching/search_windows.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Every disparity of every pixel.
class FullSearch {
 public:
  FullSearch(const MatcherParams& params, int64_t simd_target);

  /// Fills every member of `match` except search_width; all must have the images' size.
  /// @param volume  memory for the sums of all disparities; may be shared with other searches.
  void match(const cv::Mat1i& left_words, const cv::Mat1i& right_words,
             const PrincipalOffset& offset, const JumpFloors& floors, AlignedBuffer& volume,
             Match& match);

 private:
  struct Pass {
    AlignedBuffer paths;
    PathRow straight, from_behind, from_ahead;
  };
  /// Buffers of the thread that works on a row.
  struct RowWork {
    AlignedBuffer sums;
    RowWinners winners;
  };

  void start(Pass& pass, int width) const;
  FullSearchRow rowOf(const RowTask& task, const JumpFloors& floors, int width) const;
  void chooseWinners(const PrincipalOffset& offset, int y, const uint8_t* sums, RowWinners& winners,
                     Match& match) const;

  const MatcherParams params_;
  const int64_t simd_target_;
  const StripedLayout layout_;
  const CostTables tables_;
  AlignedBuffer dead_, chunk_costs_;
  CensusPlanes left_planes_, right_planes_;
  Pass downward_, upward_;
  tbb::enumerable_thread_specific<RowWork> row_works_;
};

/// A window of disparities for each run of pixels.
class ReducedSearch {
 public:
  ReducedSearch(const MatcherParams& params, int64_t simd_target);

  /// As FullSearch::match.
  void match(const cv::Mat1i& left_words, const cv::Mat1i& right_words,
             const PrincipalOffset& offset, const JumpFloors& floors, const SearchWindows& windows,
             AlignedBuffer& volume, Match& match);

 private:
  /// Goodness of the three paths that come from the previous row, before and after a row.
  struct PathRows {
    AlignedBuffer rows[2][3];
    PathStates states(int which) const {
      return {rows[which][0].data() + kBeyond, rows[which][1].data() + kBeyond,
              rows[which][2].data() + kBeyond};
    }
  };
  /// Buffers of the thread that works on a row.
  struct RowWork {
    AlignedBuffer half_sums, row_sums;  ///< row_sums begins with a margin
    WindowWinnersScratch scratch;
    RowWinners winners;
  };

  ReducedSearchRow rowOf(const RowTask& task, const cv::Mat1i& left_words, const JumpFloors& floors,
                         const SearchWindows& windows);
  void reserve(std::vector<PathRows>& paths, size_t count, int columns) const;
  RowWork& rowWork(int columns);  ///< of this thread
  void chooseWinners(const PrincipalOffset& offset, const SearchWindows& windows, int y,
                     const uint8_t* sums, RowWork& work, Match& match) const;

  const MatcherParams params_;
  const int64_t simd_target_;
  CensusBytes right_bytes_;
  AlignedBuffer costs_;
  std::vector<PathRows> paths_;  ///< one per pass, or one per strip of each pass
  tbb::enumerable_thread_specific<RowWork> row_works_;
};

}  // namespace predictive_stereo
