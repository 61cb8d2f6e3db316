/// Full search of a pair by kernels: both passes, exact for any number of threads.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <opencv2/core.hpp>

#include "matching/aligned_buffer.h"
#include "matching/census.h"
#include "matching/full_kernel.h"
#include "matching/jump_floors.h"
#include "matching/principal_offset.h"
#include "matching/row_visits.h"
#include "matching/row_winners.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// The paths of the downward pass need the rows above, those of the upward pass the rows below.
/// Therefore each pass starts on its own half of the image and stores its sums there. Then they
/// swap halves, add the sums of the other pass, and choose the winners.
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

}  // namespace predictive_stereo
