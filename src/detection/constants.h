/// Numbers of the default scheme that several of its files share, and that no robot needs to
/// change. docs/design_notes.md tells how they were set.
#pragma once

#include <cstddef>

namespace predictive_stereo {

struct DetectionConstants {
  /// Standard deviation of a tracked point's position [px].
  static constexpr double kFlowSigma_px = 0.4;
  /// Points that are tracked into one past frame; an even sample if there are more.
  static constexpr size_t kMostTracks = 500;
  /// Distances within an object, relative to MotionDetectionParams::link_distance_m: along the line
  /// of sight between points, and from its points to its end.
  static constexpr double kLinkDepth = 0.6, kReach = 1.6;
  /// Largest gap without texture within an object [m].
  static constexpr double kGap_m = 0.25;
};

}  // namespace predictive_stereo
