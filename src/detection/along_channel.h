#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/long_residual.h"
#include "detection/point_tracks.h"
#include "detection/verification.h"

namespace predictive_stereo {

/// A connected group of lattice points whose 5x5 mean residual is large and nearly all of one sign.
struct ResidualGroup {
  std::vector<cv::Point> points;  ///< lattice
  float disparity_px = 0;         ///< median
};

/// @param residual_px, pair  see longResidual. Points of a group have the same pair of frames.
/// @param disparity_px  of the frame, in full resolution.
/// @param least_mean_px  least |mean residual| over 5x5 lattice points.
/// @returns the groups, the largest one first.
std::vector<ResidualGroup> groupResiduals(const cv::Mat1f& residual_px, const cv::Mat1b& pair,
                                          const cv::Mat1f& disparity_px, float least_mean_px);

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
                                       const Verification& verification) const;

  std::vector<PastPair> pairs_;  // the farthest one first
  cv::Mat1f residual_px_;
  cv::Mat1b pair_;  // of each lattice point, see longResidual
};

}  // namespace predictive_stereo
