/// Where surfaces may end: penalties of jumps that depend on the image.
#pragma once

#include <opencv2/core.hpp>

#include "matching/aligned_buffer.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// How much less than P2 a jump of disparity costs between neighbouring pixels of the left image:
/// P2 - p2_edge where the grey level steps, else 0. Path steps take it as the least goodness that
/// any disparity passes on (path_step-inl.h).
///
/// A step is one that lasts: between pixels 0 and 1 in a row or column, by at least `edge_step`
/// both from 0 to 1 and from -2 to 3. Where a surface ends another one begins, which mostly differs
/// in grey; lines, gaps and spots have one surface on both sides.
class JumpFloors {
 public:
  /// Rows run in parallel.
  void build(const cv::Mat1b& left, const MatcherParams& params);

  /// Between pixels x - 1 and x of a row, x from 0 to the image's width. 16 bytes more can be read.
  const uint8_t* across(int y) const { return across_.data() + offsetOf(y); }
  /// Between rows y - 1 and y, y from 0 to the image's height. 16 bytes more can be read.
  const uint8_t* down(int y) const { return down_.data() + offsetOf(y); }

 private:
  size_t offsetOf(int y) const { return static_cast<size_t>(y) * stride_; }

  size_t stride_ = 0;
  AlignedBuffer across_, down_;
};

}  // namespace predictive_stereo
