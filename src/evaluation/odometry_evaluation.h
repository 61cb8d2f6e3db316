/// Ego-motion against true poses: errors per frame, relative errors as in KITTI, consistency of
/// covariances.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "evaluation/sequence.h"
#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {

using Poses = std::vector<Eigen::Isometry3d>;  ///< T_world_cam, one per frame

struct MotionError {
  double translation_m = 0;
  double rotation_rad = 0;
};
MotionError motionError(const Eigen::Isometry3d& estimated, const Eigen::Isometry3d& truth);

/// Mean error of the motions between consecutive poses; of one pose 0.
MotionError meanMotionError(const Poses& estimated, const Poses& truth);

/// KITTI's relative error over stretches of one length that start at every frame.
struct RelativePoseError {
  double length_m = 0;
  int stretches = 0;  ///< 0: the path is too short
  double translation_percent = 0;
  double rotation_deg_per_m = 0;
};
std::vector<RelativePoseError> relativePoseErrors(const Poses& estimated, const Poses& truth,
                                                  const std::vector<double>& lengths_m);

/// Error of an estimated motion, as the perturbation of CameraMotion::covariance.
Vector6d perturbation(const Eigen::Isometry3d& estimated, const Eigen::Isometry3d& truth);

/// Normalised estimation error squared of one motion, e' C^-1 e; 6 on average if covariances are
/// consistent.
/// @throws std::invalid_argument if the covariance is not positive definite.
double normalizedErrorSquared(const CameraMotion& estimated, const Eigen::Isometry3d& truth);

/// Errors of the ego-motion on one sequence with true poses.
struct OdometryEvaluation {
  std::string name;
  Poses estimated, truth;                    ///< both start at the true first pose
  std::vector<EgoMotionEstimate> estimates;  ///< one per frame: the motion from the previous one

  double length_m = 0;              ///< of the true path
  double length_error_percent = 0;  ///< of the estimated path's length; NaN: the camera stands
  MotionError mean, largest;
  std::vector<RelativePoseError> relative;  ///< over 5, 10, 20, 50, 100 m
  double mean_normalized_error = 0, median_normalized_error = 0;
  int lost = 0;
  double mean_ms = 0, median_ms = 0, p95_ms = 0;
};

/// @param max_frames  0: all.
/// @throws std::runtime_error for a sequence without true poses.
OdometryEvaluation evaluateOdometry(const Sequence& sequence, const EgoMotionParams& params,
                                    int max_frames = 0);

/// True and estimated positions of each frame, in the first camera's axes.
std::string pathsCsv(const std::vector<OdometryEvaluation>& evaluations);

}  // namespace predictive_stereo
