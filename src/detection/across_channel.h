#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/frame_view.h"
#include "detection/suspicion.h"
#include "detection/verification.h"

namespace predictive_stereo {

/// Finds objects that move across the line of sight, or fast. Points whose image a static world
/// does not explain are grouped and tracked into one frame of the past. Groups that move alike are
/// verified.
class AcrossChannel {
 public:
  /// Compares the current frame with one of the past.
  /// @param deviation  see Suspicion::find.
  /// @param ground  of the current frame: points on level ground are left out.
  void compare(const PastView& view, const cv::Mat1w& deviation, const LevelGround& ground);
  /// Share of the image that a static world does not explain. Call after compare().
  double contradictingShare() const { return suspicion_.share(); }
  /// The comparison, of the whole lattice. Valid until the next compare().
  const Comparison& staticWorld() const { return static_world_; }

  /// Adds the objects that it finds; those that were found before are not sought again. Call after
  /// compare(), with the same frames.
  void find(const PastView& view, Verification& verification);

 private:
  Comparison static_world_;
  Suspicion suspicion_;
  std::vector<cv::Point> suspects_px_, unexplained_px_;
};

}  // namespace predictive_stereo
