#pragma once

#include <opencv2/core.hpp>

#include "detection/tracker.h"
#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Whether an object that was not seen to move in this frame is still there: most of the
/// pixels that can be
/// matched in its box, moved along, has its disparity.
/// @param[out] mask  255 where it has; of the size of the box within the image.
bool isStillThere(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px,
                  const Observation& moved_along, cv::Mat1b& mask);

}  // namespace predictive_stereo
