/// Census transforms: comparisons in a pixel's neighbourhood, as bits (section 2.1).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// One comparison gives one bit: whether the first pixel is darker than the second. Offsets are
/// from the centre.
struct CensusComparison {
  int first_x, first_y, second_x, second_y;
};

constexpr int kCensusBits = 24;
constexpr int kCensusBytes = kCensusBits / 8;
constexpr int kCensusNibbles = kCensusBits / 4;  ///< groups of four bits
constexpr int kCensusMargin = 4;                 ///< largest column offset of all forms

/// The comparisons of a census form; the first of them is bit 0. The last ones may compare the
/// centre with itself, which gives 0.
using CensusPattern = std::array<CensusComparison, kCensusBits>;
CensusPattern censusPattern(CensusForm form);

/// The reference in plain C++: one census word per pixel; the image's borders are replicated.
void censusReference(const cv::Mat1b& image, CensusForm form, cv::Mat1i& words);

/// The census transform in SIMD; equals censusReference. Rows run in parallel.
class CensusKernel {
 public:
  CensusKernel(CensusForm form, int64_t simd_target) : form_(form), simd_target_(simd_target) {}

  void transform(const cv::Mat1b& image, cv::Mat1i& words);

 private:
  CensusForm form_;
  int64_t simd_target_;
  cv::Mat1b padded_;  ///< the image with replicated columns, as signed values
};

// Census words in the layouts of the two searches. In the right image words go from right to left,
// which is the order of a left pixel's partners by disparity: entry width - 1 - x + i is the right
// partner of left pixel x at index i of the column shifts (PrincipalOffset). Columns outside the
// image repeat its border.

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
