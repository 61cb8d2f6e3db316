#pragma once

#include <opencv2/core.hpp>

#include "detection/tracker.h"
#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Whether an object without observation in this frame is still there: most matched pixels in its
/// predicted box have its disparity.
/// @param moved_along  the object, predicted to this frame.
/// @param[out] mask  255 on these pixels; of the size of the box within the image.
bool isStillThere(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px,
                  const Observation& moved_along, cv::Mat1b& mask);

}  // namespace predictive_stereo
