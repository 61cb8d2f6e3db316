/// What kernels need to get Hamming distances of census words: tables by four bits.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Costs by table look-up: for the four bits of the left word, a row of 16 costs, one for each
/// value of the four bits of the right word. A byte shuffle then gives the costs of 16 or more
/// right pixels at once, without a population count.
struct CostTables {
  explicit CostTables(int p2);

  alignas(64) uint8_t distance[16][16];
  alignas(64) uint8_t distance_and_p2[16][16];  ///< P2 included, for the first four bits of a word
};

/// Groups of four bits in a word of this census form: 6 or 8.
int nibbleCount(CensusForm form);

/// The census words of the right image, as kernels read them: for a left pixel x and r0 =
/// width - 1 - x, entry r0 + i is the right partner at disparity index i. Columns outside the image
/// repeat the border. Entries are dealt out over `phases` planes (entry r is in plane r % phases at
/// r / phases), and each plane holds one byte per four bits of the word.
class RightWords {
 public:
  void build(const cv::Mat1i& words, const DisparityRange& range, int nibbles, int phases);

  /// Plane `phase` of row y for bits 4 `nibble`, ...
  const uint8_t* plane(int y, int phase, int nibble) const {
    return planes_[y] + (static_cast<size_t>(phase) * nibbles_ + nibble) * stride_;
  }
  size_t stride() const { return stride_; }

 private:
  int nibbles_ = 0;
  size_t stride_ = 0;  ///< bytes from one nibble's plane to the next one's
  cv::Mat1b planes_;
};

}  // namespace predictive_stereo
