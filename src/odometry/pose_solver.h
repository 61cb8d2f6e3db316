#pragma once

#include <Eigen/Core>
#include <vector>

#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {

/// One point seen in two stereo pairs: (x, y, disparity) [px] in the previous and the current one.
struct Correspondence {
  Eigen::Vector3d previous, current;
  double track_variance = 1;               ///< of current x and y, relative to the others
  double previous_disparity_variance = 1;  ///< relative to the others
  double current_disparity_variance = 1;   ///< relative to the others
  double trust = 1;  ///< weight in the vote between motions: how likely the point is static
};

struct PoseSolverParams {
  double outlier_sigma = 4.0;  ///< residuals beyond this many sigma do not count as inliers
  int max_hypotheses = 400;
  int min_inliers = 10;
};

struct PoseSolution {
  bool found = false;
  Eigen::Isometry3d T_cam_prev = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< as CameraMotion::covariance
  std::vector<char> inlier;                ///< one per correspondence
  int inliers = 0;
  double sigma_px = 0;     ///< scale of the residuals, for a relative variance of 1
  double residual_px = 0;  ///< root mean square of the inliers' residuals in x, y, d
};

/// The motion that most correspondences agree with: RANSAC on three points, with a fixed seed, then
/// robust Gauss-Newton. Residuals are weighted with the noise of all six coordinates of a
/// correspondence, the previous disparity's included, propagated to the current frame.
/// @param T_expected  competes with the random hypotheses.
PoseSolution solvePose(const StereoRig& rig, const std::vector<Correspondence>& correspondences,
                       const Eigen::Isometry3d& T_expected, double expected_sigma_px,
                       const PoseSolverParams& params);

}  // namespace predictive_stereo
