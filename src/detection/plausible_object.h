#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "detection/ground.h"
#include "detection/road_line.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// Where the lower end of what is seen of an object lies.
enum class LowerEnd {
  kFoot,    ///< where it stands
  kHidden,  ///< behind something nearer
  kCut      ///< at the lower edge of the image
};

/// @param layer_px  disparity of the object.
/// @param nearest_px  largest disparity of its layer.
LowerEnd lowerEndOf(const StereoRig& rig, const DisparityRange& range,
                    const cv::Mat1f& disparity_px, const LevelGround& ground,
                    const cv::Rect& box_px, float layer_px, float nearest_px);

/// Whether a road user may have this size and be seen at this height.
/// @param depth_m  of its centre.
/// @param layer_px  disparity of the object.
/// @param road  none: heights are not asked.
bool isPlausible(const StereoRig& rig, const MotionDetectionParams& params,
                 const std::optional<RoadLine>& road, const cv::Rect& box_px, double depth_m,
                 float layer_px, LowerEnd lower_end);

}  // namespace predictive_stereo
