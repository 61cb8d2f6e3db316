/// What the default scheme of detection can see at all: limits that follow from the rig.
#pragma once

#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/stereo_rig.h"
#include "predictive_stereo/variance.h"

namespace predictive_stereo {

/// Slowest speeds over ground that can be told from standing still [m/s]; infinite where none can.
struct DetectableSpeed {
  double across_mps = 0;  ///< at right angles to the line of sight
  /// Along it, on the optical axis, coming towards the camera, from one frame to the next. Frames
  /// further back show slower motion, at best an eighth.
  double along_mps = 0;
};

/// The limits at one depth, for an object that is large and textured enough.
///
/// An object on the optical axis that moves across by m changes its column by fx m / Z, one that
/// moves along by m changes its disparity by fx B m / (Z (Z + m)). The detector compares with
/// frames two back and more. Over two frames these changes have to exceed the thresholds of
/// MotionDetectionParams: min_mahalanobis against the noise of flow, disparity and ego-motion; or,
/// along the line of sight, dense_min_residual_px on average. So the
/// speed across grows with Z at most, that along with Z^2: what drives along far away cannot be
/// seen in disparity, whatever the thresholds. Off the axis motion along the line of sight also
/// moves the image, and is seen earlier.
/// @param frame_interval_s  time between two frames.
/// @throws std::invalid_argument for a depth or an interval that is not positive.
DetectableSpeed detectableSpeed(const StereoRig& rig, double depth_m, double frame_interval_s,
                                const MotionDetectionParams& detection = {},
                                const VarianceParams& variance = {});

}  // namespace predictive_stereo
