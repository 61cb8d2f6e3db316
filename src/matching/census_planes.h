/// Census words in the layout of the full search: planes of four bits, one byte each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Four-bit planes of every row. Bits 4 n, ... of row y begin at row(y) + n * plane_stride().
class CensusPlanes {
 public:
  explicit CensusPlanes(int64_t simd_target) : simd_target_(simd_target) {}

  /// Of the left image, in the order of columns. Bytes hold 16 times their four bits, which is the
  /// position of a row of CostTables.
  void buildLeft(const cv::Mat1i& words);

  /// Of the right image, in the order of entries: for a left pixel x, entry width - 1 - x + i is
  /// its right partner at index i of `shifts` (PrincipalOffset). Columns outside the image repeat
  /// the border. Entries are interleaved: entries e and e + phases are neighbours in memory.
  void buildRight(const cv::Mat1i& words, const DisparityRange& shifts, int phases);

  const uint8_t* row(int y) const { return planes_[y]; }
  size_t plane_stride() const { return plane_stride_; }
  /// Position of each entry in its plane.
  const uint32_t* entry_offsets() const { return entry_offsets_.data(); }

 private:
  int64_t simd_target_;
  size_t plane_stride_ = 0;
  std::vector<uint32_t> entry_offsets_;
  cv::Mat1i ordered_;  ///< words in the order of memory, phase by phase
  cv::Mat1b planes_;
};

}  // namespace predictive_stereo
