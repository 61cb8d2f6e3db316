/// Removes small regions of a disparity map.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Invalidates small regions: pixels that are connected, above, below, left or right, by steps of
/// at most 1 px of disparity belong to one region. A false match is surrounded by others that
/// differ; a surface continues. Keeps its buffers between calls, so that equal sizes allocate
/// nothing.
class RegionFilter {
 public:
  /// @param min_region_px  regions of fewer pixels become invalid; at most 1: nothing does.
  /// @param disparity_px  any size; is changed: pixels of small regions become range.invalid().
  void filter(const DisparityRange& range, int min_region_px, cv::Mat1f& disparity_px);

 private:
  /// Connected pixels of a row.
  struct Run {
    int32_t begin, end;  ///< columns
    int32_t parent;      ///< another run of the region, or the run itself
    int32_t pixels;      ///< of the region, where the run is its own parent
  };

  void findRuns(const cv::Mat1f& disparity_px, float smallest_valid);
  void connectRows(int y);
  int32_t rootOf(int32_t run);
  void unite(int32_t a, int32_t b);

  cv::Mat1b across_, down_;  ///< 1: connected with the next column, row
  std::vector<Run> runs_;    ///< of row y from y * width on
  std::vector<int32_t> run_count_;
};

}  // namespace predictive_stereo
