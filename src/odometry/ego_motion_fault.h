#pragma once

#include <Eigen/Geometry>

#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {

/// For tests: sets a wrong expectation of the motion model.
struct EgoMotionFault {
  /// Sets the motion that is expected again in the next frame.
  static void setExpectedMotion(EgoMotion& ego_motion, const Eigen::Isometry3d& T_cam_prev);
  static Eigen::Isometry3d expectedMotion(const EgoMotion& ego_motion);
};

}  // namespace predictive_stereo
