/// The slowest motion that the default detection scheme can detect with a given rig.
#pragma once

#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/stereo_rig.h"
#include "predictive_stereo/variance.h"

namespace predictive_stereo {

/// Slowest speeds over ground that can be distinguished from a static object [m/s]; infinity where
/// no speed can.
struct DetectableSpeed {
  double across_mps = 0;  ///< at right angles to the line of sight
  /// Along the line of sight, towards the camera, on the optical axis. Comparison with frames
  /// further back detects slower motion, down to a quarter of this at best.
  double along_mps = 0;
};

/// The limits at one depth, for an object that is large and textured enough.
///
/// An object on the optical axis at depth Z that moves across the line of sight by m changes its
/// column by fx m / Z. One that moves along it by m changes its disparity by fx B m / (Z (Z + m)).
/// The detector compares with the second of the past frames that are at least 80 ms apart; at 13 to
/// 25 frames per second it compares images with the first one only. Since that frame these changes
/// must exceed the thresholds of MotionDetectionParams: min_mahalanobis against the noise of flow,
/// disparity and ego-motion; or, along the line of sight, dense_min_residual_px on average. The
/// limit across therefore grows with Z at most, the limit along the line of sight with Z^2. Far
/// away the disparity does not show motion along the line of sight, whatever the thresholds. Off
/// the optical axis such motion also moves the image, and is detected earlier.
/// @param rig  only size, fx_px and baseline_m are used: the detector rescales small and large
/// images.
/// @param depth_m  Z of the object.
/// @param frame_interval_s  time between two frames.
/// @throws std::invalid_argument if depth_m or frame_interval_s is not positive and finite.
DetectableSpeed detectableSpeed(const StereoRig& rig, double depth_m, double frame_interval_s,
                                const MotionDetectionParams& detection = {},
                                const VarianceParams& variance = {});

}  // namespace predictive_stereo
