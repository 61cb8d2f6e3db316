#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "detection/depth_cells.h"
#include "detection/ground_plane.h"
#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

/// What the lower end of an object's visible part is.
enum class LowerEnd {
  kFoot,    ///< the object's lower end
  kHidden,  ///< an occlusion by a nearer surface
  kCut      ///< the lower edge of the image
};

/// @param ground  none: what is below an object counts as the ground that it stands on.
/// @param nearest_px  largest disparity of the object.
LowerEnd lowerEndOf(const DepthCells& cells, const std::optional<GroundPlane>& ground,
                    const cv::Rect& box_px, float nearest_px);

/// What is visible of an object.
struct Extent {
  struct Heights {
    double foot_m, top_m;
  };
  double width_m, height_m;
  std::optional<Heights> above_ground;  ///< of its ends; none: no ground is in view
};

/// Whether size and height above the ground are possible for an object.
bool isPlausible(const MotionDetectionParams& params, const Extent& extent, LowerEnd lower_end,
                 double distance_m);

}  // namespace predictive_stereo
