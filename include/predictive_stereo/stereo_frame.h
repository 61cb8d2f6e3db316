/// One stereo pair of a sequence.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/sequence_guard.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

struct StereoFrame {
  /// Rectified 8-bit grey images of rig.size. They must stay alive and unchanged until the frame is
  /// processed.
  cv::Mat1b left, right;
  StereoRig rig;
  Stamp stamp{};
  /// Not 0 where the left camera sees the robot itself, which moves with it: no part in the
  /// ego-motion, no disparity there. Empty, or of rig.size.
  cv::Mat1b robot_mask{};
};

/// @throws std::invalid_argument if an image does not have rig.size.
void requireSizes(const StereoFrame& frame);

}  // namespace predictive_stereo
