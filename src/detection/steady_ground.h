#pragma once

#include <optional>

#include "detection/depth_cells.h"
#include "detection/ground_plane.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// The ground of a sequence: a plane that two successive frames show. Where the ground has no
/// texture, each frame has another plane, of noise and walls.
class SteadyGround {
 public:
  void setFrame(const StereoRig& rig, const DepthCells& cells);
  /// Of this frame; none if it has no ground.
  const std::optional<GroundPlane>& plane() const { return plane_; }
  void reset() { *this = SteadyGround(); }

 private:
  std::optional<GroundPlane> plane_;
  std::optional<GroundPlane> candidate_;  // of this frame, and the first trial of the next one
};

}  // namespace predictive_stereo
