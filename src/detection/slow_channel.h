#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/dense_channel.h"
#include "detection/hypothesis.h"
#include "detection/layer_motion.h"
#include "detection/long_residual.h"
#include "detection/verification.h"

namespace predictive_stereo {

/// Finds what moves slowly along the line of sight: one frame shows too little of it, so that the
/// current frame is compared with frames farther back, as far as static points have not moved much
/// since. Motion adds up over frames, errors of disparities do not. Its points are followed into
/// the past, or, where too few of them are found again, the disparities of all past frames are
/// asked.
class SlowChannel {
 public:
  /// @param past  frames before this one, the last first; at least one.
  void setFrame(const FrameView& frame, const std::vector<PastFrame>& past);
  /// Adds what it finds.
  void find(const FrameView& frame, Verification& verification);
  /// Adds known objects that are where they should be. After find().
  void findKnown(const FrameView& frame, const std::vector<const ObjectTrack*>& known,
                 Verification& verification) const;

 private:
  std::optional<VerifiedObject> byTracks(const FrameView& frame, const DenseGroup& group,
                                         const Verification& verification,
                                         VerificationWork& work) const;
  std::optional<VerifiedObject> byDisparities(const FrameView& frame, Hypothesis hypothesis,
                                              const std::optional<Eigen::Vector3d>& expected_mps,
                                              const Verification& verification,
                                              VerificationWork& work) const;
  std::optional<VerifiedObject> verify(const FrameView& frame, const PastFrame& past,
                                       const Hypothesis& hypothesis,
                                       const DisparityHistory* history,
                                       const Verification& verification,
                                       VerificationWork& work) const;

  std::vector<PastPair> pairs_;  // the farthest first
  std::optional<DisparityHistory> history_;
  cv::Mat1f residual_px_;
  cv::Mat1b pair_;  // of each lattice point, see longResidual
  DenseGroups groups_;
};

}  // namespace predictive_stereo
