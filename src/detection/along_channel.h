#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/hypothesis.h"
#include "detection/long_residual.h"
#include "detection/residual_groups.h"
#include "detection/verification.h"

namespace predictive_stereo {

/// Finds objects that move along the line of sight: the image hardly changes, the disparity does.
/// One
/// frame shows too little of it. So the current frame is compared with frames farther back, as far
/// as static points have not moved much in the image since. Motion adds up over frames, errors of
/// disparities do not.
class AlongChannel {
 public:
  /// @param past  frames before this one, the last first; at least one.
  void compare(const FrameView& frame, const std::vector<PastFrame>& past);
  /// See longResidual; of the lattice. After compare().
  const cv::Mat1f& residual_px() const { return residual_px_; }
  /// Adds what it finds. After compare().
  void find(const FrameView& frame, Verification& verification);

 private:
  std::optional<VerifiedObject> verify(const FrameView& frame, const ResidualGroup& group,
                                       const Verification& verification,
                                       VerificationWork& work) const;

  std::vector<PastPair> pairs_;  // the farthest first
  cv::Mat1f residual_px_;
  cv::Mat1b pair_;  // of each lattice point, see longResidual
  ResidualGroups groups_;
};

}  // namespace predictive_stereo
