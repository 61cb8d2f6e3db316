/// Penalties of disparity jumps, lower at grey edges, where surfaces may end.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Reduction of P2 for a disparity jump between neighbouring pixels of the left image: P2 - p2_edge
/// at grey edges, else 0. Path steps use it as the minimum of the goodness that any disparity
/// passes on (path_step-inl.h).
///
/// An edge between pixels 0 and 1 of a row or column is a grey step of at least `edge_step` both
/// from 0 to 1 and from -2 to 3. At an occlusion boundary the grey level mostly differs on both
/// sides. The second condition excludes lines, gaps and spots, which have one surface on both
/// sides.
class JumpFloors {
 public:
  void build(const cv::Mat1b& left, const MatcherParams& params);

  /// Between pixels x - 1 and x of a row, x from 0 to the image's width. 16 more bytes can be read.
  const uint8_t* across(int y) const { return across_[y]; }
  /// Between rows y - 1 and y, y from 0 to the image's height. 16 more bytes can be read.
  const uint8_t* down(int y) const { return down_[y]; }

 private:
  cv::Mat1b padded_, far_steps_;
  cv::Mat1b across_, down_;
};

}  // namespace predictive_stereo
