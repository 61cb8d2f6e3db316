#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/hypothesis.h"
#include "detection/long_residual.h"
#include "detection/residual_groups.h"
#include "detection/verification.h"

namespace predictive_stereo {

/// Finds objects that move along the line of sight, which changes the disparity but hardly the
/// image. Between two successive frames the change is too small. Therefore the current frame is
/// compared with frames farther back, as long as static points have not moved much in the image
/// since then: motion accumulates over frames, errors of disparities do not.
class AlongChannel {
 public:
  /// @param past  previous frames, the last one first; at least one.
  void compare(const FrameView& frame, const std::vector<PastFrame>& past);
  /// The residual of each lattice point, see longResidual. Call after compare().
  const cv::Mat1f& residual_px() const { return residual_px_; }
  /// Adds the objects that it finds. Call after compare().
  void find(const FrameView& frame, Verification& verification);

 private:
  std::optional<VerifiedObject> verify(const FrameView& frame, const ResidualGroup& group,
                                       const Verification& verification,
                                       SegmentationWork& work) const;

  std::vector<PastPair> pairs_;  // the farthest one first
  cv::Mat1f residual_px_;
  cv::Mat1b pair_;  // of each lattice point, see longResidual
};

}  // namespace predictive_stereo
