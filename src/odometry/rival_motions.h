/// Comparison of motion hypotheses for one frame.
#pragma once

#include <vector>

#include "odometry/pose_solver.h"
#include "odometry/reference_frame.h"

namespace predictive_stereo {

/// Sum of the trust of the inliers of a motion.
double support(const PoseSolution& solution, const std::vector<Correspondence>& correspondences);

/// Whether motion `a` is preferred to `b`. If both have similar support, the one with the smaller
/// covariance is: static points surround the camera, those of a moving object are close together.
bool isPreferred(const PoseSolution& a, double support_a, const PoseSolution& b, double support_b);

/// Whether two motions predict most features at the same positions.
bool predictSamePositions(const StereoRig& rig, const ReferenceFrame& reference,
                          const Eigen::Isometry3d& T_a, const Eigen::Isometry3d& T_b);

/// The 0.9 quantile of the values, which are reordered; there must be at least one.
double highQuantile(std::vector<double>& values);

}  // namespace predictive_stereo
