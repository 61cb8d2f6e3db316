#pragma once

#include <optional>
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

inline bool isRotation(const Eigen::Matrix3d& R) {
  return R.isUnitary(1e-6) && R.determinant() > 0;
}

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
  /// What others say of the rotation since that previous one: takes directions of its camera to
  /// today's. None: they have not told of all frames.
  std::optional<Eigen::Matrix3d> R_since = Eigen::Matrix3d(Eigen::Matrix3d::Identity());

  /// One more frame has passed. What is no rotation counts as none.
  void addFrame(const std::optional<Eigen::Matrix3d>& R_cam_prev) {
    ++age;
    if (R_since && R_cam_prev && isRotation(*R_cam_prev))
      R_since = *R_cam_prev * *R_since;
    else
      R_since.reset();
  }
};

}  // namespace predictive_stereo
