#pragma once

#include <vector>

#include "odometry/image_pyramid.h"
#include "odometry/pose_solver.h"
#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {

/// A corner of a frame, with its disparity as measured [px].
struct Feature {
  cv::Point2f position;
  float disparity_px = 0;
  double disparity_variance = 1;  ///< as Correspondence::previous_disparity_variance
  double trust = 1;               ///< as Correspondence::trust
};

/// The frame that motion is measured against: the previous one, or an earlier one while the camera
/// stands still or nothing can be seen.
struct ReferenceFrame {
  ImagePyramid left;
  std::vector<Feature> features;
  DisparityOffset offset;
  /// The previous frame's pose as seen from here: takes points from this frame to the previous one.
  /// The covariance is that of noise alone.
  CameraMotion to_previous;
  DisparityErrors by_disparity_errors = DisparityErrors::Zero();  ///< of to_previous
  int age = 0;  ///< frames since that previous one
};

}  // namespace predictive_stereo
