#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/frame_view.h"
#include "detection/suspicion.h"
#include "detection/verification.h"

namespace predictive_stereo {

/// Finds objects that move across the line of sight, or fast: the static world does not explain
/// the image
/// as seen from one frame of the past. Points of it are grouped, found again there, and what moves
/// alike is verified.
class AcrossChannel {
 public:
  /// Compares the current frame with one of the past.
  /// @param ground  of the current frame: level ground is no suspect.
  void compare(const FrameView& frame, const PastFrame& past, const LevelGround& ground);
  /// The share of the image that the static world does not explain. After compare().
  double contradictingShare() const { return suspicion_.share(); }
  /// Valid until the next compare().
  Baseline baseline() const { return {past_, static_world_}; }

  /// Adds what it finds. After compare().
  void find(const FrameView& frame, Verification& verification);

 private:
  PastFrame past_;
  Comparison static_world_;
  Suspicion suspicion_;
  std::vector<cv::Point> suspects_px_, unexplained_px_;
};

}  // namespace predictive_stereo
