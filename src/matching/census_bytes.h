/// Census words of the right image in the layout of the reduced search: from right to left, which
/// is the order of a left pixel's partners by disparity, with one plane for each byte of the words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

class CensusBytes {
 public:
  explicit CensusBytes(int64_t simd_target) : simd_target_(simd_target) {}

  /// @param shifts  of columns, see PrincipalOffset.
  void build(const cv::Mat1i& right_words, const DisparityRange& shifts);

  /// Byte 0 of the words of row y. For a left pixel x, entry width - 1 - x + i is its right partner
  /// at index i of the shifts; columns outside the image repeat its border. One vector may be read
  /// behind the last entry.
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
