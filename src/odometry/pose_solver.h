#pragma once

#include <Eigen/Core>
#include <vector>

#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {

/// One point seen in two stereo pairs: (x, y, disparity) [px] in the previous and the current one.
struct Correspondence {
  Eigen::Vector3d previous, current;
  /// Of current x and y, relative to the others.
  Eigen::Vector2d track_variance = Eigen::Vector2d::Ones();
  double previous_disparity_variance = 1;  ///< relative to the others
  double current_disparity_variance = 1;   ///< relative to the others
  double trust = 1;  ///< weight in the vote between motions: how likely the point is static
};

struct PoseSolverParams {
  double outlier_sigma = 4.0;  ///< residuals beyond this many sigma do not count as inliers
  int max_hypotheses = 400;
  int min_inliers = 10;
  /// How much the offset of all disparities varies from frame to frame [px]: cameras on a bumpy
  /// road shake against each other. 0: not at all.
  double offset_jitter_px = 0.5;
  /// By which errors that neighbouring points have in common enlarge the covariance; 1: none.
  double common_errors = 1;
};

/// A constant that is missing in every measured disparity, as after a small turn of one camera.
struct DisparityOffset {
  double offset_px = 0;     ///< to be added to every measured disparity
  double variance_px2 = 0;  ///< 0: known
};

using DisparityErrors = Eigen::Matrix<double, 6, 3>;

struct PoseSolution {
  bool found = false;
  Eigen::Isometry3d T_cam_prev = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< as CameraMotion::covariance
  /// Error of the motion by what is wrong with all disparities: by one sigma of the offset, and by
  /// an error that is 0 in the image's centre and 1 px at its right or its lower border.
  DisparityErrors by_disparity_errors = DisparityErrors::Zero();
  std::vector<char> inlier;  ///< one per correspondence
  int inliers = 0;
  DisparityOffset offset;  ///< of the current frame
  double sigma_px = 0;     ///< scale of the residuals, for a relative variance of 1
  double residual_px = 0;  ///< root mean square of the inliers' residuals in x, y, d
};

/// The motion that most correspondences agree with: RANSAC on three points, with a fixed seed, then
/// robust Gauss-Newton. Residuals are weighted with the noise of all six coordinates of a
/// correspondence, the previous disparity's included, propagated to the current frame.
/// @param T_expected  competes with the random hypotheses.
/// @param previous_offset  of the previous frame, before this one was seen.
PoseSolution solvePose(const StereoRig& rig, const std::vector<Correspondence>& correspondences,
                       const Eigen::Isometry3d& T_expected, const DisparityOffset& previous_offset,
                       double expected_sigma_px, const PoseSolverParams& params);

}  // namespace predictive_stereo
