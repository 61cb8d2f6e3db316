#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {

/// One point in two stereo pairs: (x, y, disparity) [px] in the previous and the current one.
struct Correspondence {
  Eigen::Vector3d previous, current;
  /// Variance of current x and y. All variances are relative to a common, unknown one.
  Eigen::Vector2d track_variance = Eigen::Vector2d::Ones();
  double previous_disparity_variance = 1;
  double current_disparity_variance = 1;
  double trust = 1;  ///< likelihood that the point is static: its weight in RANSAC
};

struct PoseSolverParams {
  double outlier_sigma = 4.0;  ///< residuals beyond this many sigma do not count as inliers
  int max_hypotheses = 400;
  int min_inliers = 10;
  /// Standard deviation [px] of the disparity offset from frame to frame: on a bumpy road the
  /// cameras shake against each other. 0: the offset is constant.
  double offset_jitter_px = 0.5;
  /// Where the camera is likely to be, in the axes of the previous frame.
  Eigen::Vector3d likely_position_m = Eigen::Vector3d::Zero();
  double likely_radius_m = std::numeric_limits<double>::infinity();
  /// Factor of the covariance for correlated errors of neighbouring points; 1: no correlation.
  double common_errors = 1;
};

/// Constant error of all measured disparities, as after a small turn of one camera.
struct DisparityOffset {
  double offset_px = 0;     ///< to be added to every measured disparity
  double variance_px2 = 0;  ///< 0: the offset is known
};

using DisparityErrors = Eigen::Matrix<double, 6, 3>;

struct PoseSolution {
  bool found = false;  ///< false also if the points are too far to tell the translation
  Eigen::Isometry3d T_cam_prev = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< as CameraMotion::covariance
  /// Effect of disparity errors on the motion, one column each: one sigma of the offset; an error
  /// of 0 px in the image's centre and 1 px at its right border; the same for its lower border.
  DisparityErrors by_disparity_errors = DisparityErrors::Zero();
  std::vector<char> inlier;  ///< one per correspondence
  int inliers = 0;
  DisparityOffset offset;  ///< of the current frame
  double sigma_px = 0;     ///< scale of the residuals, for a relative variance of 1
  double residual_px = 0;  ///< root mean square of the inliers' residuals in x, y, d
};

/// The motion with the most support: RANSAC on three points, with a fixed seed, then robust
/// Gauss-Newton. Residuals are weighted with the noise of all coordinates of a correspondence, that
/// of the previous disparity propagated to the current frame.
///
/// RANSAC must allow for the noise of three points, which is far larger than that of all. A motion
/// between that of the static scene and that of a near object can then win: a small turn hides a
/// move to the side from all far points. Gauss-Newton therefore also starts from the expected
/// motion. Of the two results the one with more support() at the smaller of their noises is taken.
/// @param T_expected  a further hypothesis.
/// @param previous_offset  the estimate for the previous frame.
/// @param expected_sigma_px  of a coordinate with relative variance 1.
PoseSolution solvePose(const StereoRig& rig, const std::vector<Correspondence>& correspondences,
                       const Eigen::Isometry3d& T_expected, const DisparityOffset& previous_offset,
                       double expected_sigma_px, const PoseSolverParams& params);

/// What a motion's support is divided by: 1, or more if the camera is hardly there, even by three
/// sigma of the motion.
double unlikeliness(const PoseSolution& solution, const PoseSolverParams& params);

}  // namespace predictive_stereo
