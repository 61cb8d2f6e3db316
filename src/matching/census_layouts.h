/// Census words in the layouts of the two searches. In the right image words go from right to left,
/// which is the order of a left pixel's partners by disparity: entry width - 1 - x + i is the right
/// partner of left pixel x at index i of the column shifts (PrincipalOffset). Columns outside the
/// image repeat its border.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// For the full search: planes of four bits, one byte each. Bits 4 n, ... of row y begin at
/// row(y) + n * plane_stride().
class CensusPlanes {
 public:
  explicit CensusPlanes(int64_t simd_target) : simd_target_(simd_target) {}

  /// Of the left image, in the order of columns. Bytes hold 16 times their four bits, which is the
  /// position of a row of CostTables.
  void buildLeft(const cv::Mat1i& words);

  /// Of the right image, in the order of entries. They are interleaved: entries e and e + phases
  /// are neighbours in memory.
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

/// For the reduced search, of the right image: one plane for each byte of the words.
class CensusBytes {
 public:
  explicit CensusBytes(int64_t simd_target) : simd_target_(simd_target) {}

  void build(const cv::Mat1i& right_words, const DisparityRange& shifts);

  /// Byte 0 of the words of row y. One vector may be read behind the last entry.
  const uint8_t* row(int y) const { return planes_[y] + row_offset_; }
  /// Distance between the planes of two successive bytes.
  size_t plane_stride() const { return plane_stride_; }

 private:
  const int64_t simd_target_;
  size_t plane_stride_ = 0;
  int row_offset_ = 0;
  cv::Mat1b planes_;
};

}  // namespace predictive_stereo
