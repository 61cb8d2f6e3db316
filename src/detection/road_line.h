#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// The road as v-disparity shows it: on a plane without roll the disparity grows evenly with the
/// row, however the camera is pitched.
struct RoadLine {
  double horizon_row_px = 0;     ///< where the disparity would be 0
  double disparity_per_row = 0;  ///< baseline over height of the camera above the plane

  /// Height above the road of what is seen in this row at this disparity [m].
  double heightOf(double row_px, double disparity_px, double baseline_m) const {
    return (horizon_row_px + disparity_px / disparity_per_row - row_px) * baseline_m / disparity_px;
  }
};

/// Fits the line to the lower half of the image, robustly and with a fixed seed. None where less
/// than a fifth of it lies on one plane that a camera 0.15 to 4 m above it would see.
std::optional<RoadLine> fitRoadLine(const StereoRig& rig, const DisparityRange& range,
                                    const cv::Mat1f& disparity_px);

}  // namespace predictive_stereo
