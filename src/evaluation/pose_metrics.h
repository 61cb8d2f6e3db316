/// Metrics of ego-motion: errors per frame, relative errors as in KITTI, consistency of
/// covariances.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "predictive_stereo/disparity_motion.h"

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

}  // namespace predictive_stereo
