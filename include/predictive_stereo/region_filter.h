/// Removes small regions of a disparity map.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Invalidates small regions. Two 4-connected neighbours belong to one region if their disparities
/// differ by at most 1 px. False matches differ from their neighbours; a surface continues. Keeps
/// its buffers between calls: maps of equal size allocate nothing.
class RegionFilter {
 public:
  /// @param min_region_px  regions of fewer pixels become invalid; at most 1: none does.
  /// @param disparity_px  of any size; in place: pixels of small regions become range.invalid().
  void filter(const DisparityRange& range, int min_region_px, cv::Mat1f& disparity_px);

 private:
  /// Connected pixels of a row: a node of the union-find forest of regions.
  struct Run {
    int32_t begin, end;  ///< columns
    int32_t parent;      ///< another run of the region; the run itself if it is the root
    int32_t pixels;      ///< of the region, if the run is its root
  };

  void findRuns(const cv::Mat1f& disparity_px, float smallest_valid);
  void connectRows(int y);
  int32_t rootOf(int32_t run);
  void unite(int32_t a, int32_t b);

  cv::Mat1b across_, down_;  ///< 1: connected with the next column, row
  std::vector<Run> runs_;    ///< those of row y start at index y * width
  std::vector<int32_t> run_count_;
};

}  // namespace predictive_stereo
