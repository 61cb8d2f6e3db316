#pragma once

#include <vector>

#include "detection/tracker.h"
#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Makes one object of parts that have one velocity and between which nothing farther is seen, such
/// as the front and the rear wheel of a car that passes. The velocity of the part with the larger
/// box is kept; box, mask and shape are those of all pixels.
/// @param max_width_m  what were wider together stays apart.
void joinParts(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px,
               double max_width_m, std::vector<ObservedObject>& objects);

}  // namespace predictive_stereo
