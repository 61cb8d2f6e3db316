/// The census words of the right image in the order in which kernels read them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// For a left pixel x, entry width - 1 - x + i is its right partner at disparity index i. Columns
/// outside the image repeat the border. Entries are dealt out over `phases` planes (entry e is in
/// plane e % phases at e / phases), and each plane holds one byte per four bits of the word.
class RightWords {
 public:
  explicit RightWords(int64_t simd_target) : simd_target_(simd_target) {}

  void build(const cv::Mat1i& words, const DisparityRange& range, int nibbles, int phases);

  /// The planes of row y: plane p, bits 4 n, ... begin at (p * nibbles + n) * stride().
  const uint8_t* row(int y) const { return planes_[y]; }
  size_t stride() const { return stride_; }

 private:
  int64_t simd_target_;
  size_t stride_ = 0;
  cv::Mat1i ordered_;  ///< words in the order of entries, phase by phase
  cv::Mat1b planes_;
};

}  // namespace predictive_stereo
