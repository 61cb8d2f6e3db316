#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "imaging/image_pyramid.h"
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

/// The frame that motion is estimated against: the previous one, or an earlier one while the camera
/// stands still or no features are visible.
struct ReferenceFrame {
  ImagePyramid left;
  std::vector<Feature> features;
  DisparityOffset offset;
  /// Maps points from this frame to the last frame whose motion was estimated against it; at first
  /// this is the frame itself. The covariance contains noise only, no calibration errors.
  CameraMotion to_previous;
  DisparityErrors by_disparity_errors = DisparityErrors::Zero();  ///< of to_previous
  int age = 0;                                                    ///< frames since that last frame
  double since_s = 0;  ///< time since that last frame; infinite: not known
  /// Rotation since that last frame, from another sensor: maps directions of its camera to those of
  /// the current one. None: the sensor has not measured all frames since then.
  std::optional<Eigen::Matrix3d> R_since = Eigen::Matrix3d(Eigen::Matrix3d::Identity());

  /// Counts a frame, with its rotation. A matrix that is not a rotation counts as none.
  /// @param interval_s  see EgoMotion::estimate; what is not a time counts as not known.
  void addFrame(const std::optional<Eigen::Matrix3d>& R_cam_prev, double interval_s) {
    ++age;
    since_s += interval_s > 0 ? interval_s : std::numeric_limits<double>::infinity();
    if (R_since && R_cam_prev && isRotation(*R_cam_prev))
      R_since = *R_cam_prev * *R_since;
    else
      R_since.reset();
  }
};

}  // namespace predictive_stereo
