#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// The road as a line in v-disparity: on a plane without roll the disparity grows linearly with the
/// row, for any pitch of the camera.
struct RoadLine {
  double horizon_row_px = 0;     ///< row with disparity 0
  double disparity_per_row = 0;  ///< baseline over height of the camera above the plane

  /// Height [m] above the road of a point in this row with this disparity.
  double heightOf(double row_px, double disparity_px, double baseline_m) const {
    return (horizon_row_px + disparity_px / disparity_per_row - row_px) * baseline_m / disparity_px;
  }
};

/// Fits the line to the lower half of the image, by RANSAC with a fixed seed. None if less than a
/// fifth of it is on one plane 0.15 to 4 m below the camera.
std::optional<RoadLine> fitRoadLine(const StereoRig& rig, const DisparityRange& range,
                                    const cv::Mat1f& disparity_px);

}  // namespace predictive_stereo
