#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "detection/ground.h"
#include "detection/road_line.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// Largest height of an object's lower end above the ground [m].
/// @param is_hidden  something nearer hides the lower end: of the highest object at most half.
double highestEnd_m(const MotionDetectionParams& params, bool is_hidden, double distance_m);

/// What the lower end of an object's visible part is.
enum class LowerEnd {
  kFoot,    ///< the object's lower end
  kHidden,  ///< an occlusion by a nearer surface
  kCut      ///< the lower edge of the image
};

/// @param layer_px  disparity of the object.
/// @param nearest_px  largest disparity of its layer.
LowerEnd lowerEndOf(const StereoRig& rig, const DisparityRange& range,
                    const cv::Mat1f& disparity_px, const LevelGround& ground,
                    const cv::Rect& box_px, float layer_px, float nearest_px);

/// Whether size and height above the road are plausible for an object.
/// @param depth_m  of its centre.
/// @param layer_px  disparity of the object.
/// @param road  none: the height above the road is not checked.
bool isPlausible(const StereoRig& rig, const MotionDetectionParams& params,
                 const std::optional<RoadLine>& road, const cv::Rect& box_px, double depth_m,
                 float layer_px, LowerEnd lower_end);

}  // namespace predictive_stereo
