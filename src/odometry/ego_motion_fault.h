#pragma once

#include <Eigen/Geometry>

#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {

/// Of tests: makes the motion model expect something wrong.
struct EgoMotionFault {
  /// The motion that the next frame is expected to repeat.
  static void setExpectedMotion(EgoMotion& ego_motion, const Eigen::Isometry3d& T_cam_prev);
  static Eigen::Isometry3d expectedMotion(const EgoMotion& ego_motion);
};

}  // namespace predictive_stereo
