/// Comparison of motion hypotheses for one frame.
#pragma once

#include <vector>

#include "odometry/pose_solver.h"
#include "odometry/reference_frame.h"

namespace predictive_stereo {

/// How much speaks for a motion that was found: the trust of its inliers, divided by the geometric
/// mean of its six standard deviations. Static points are many and surround the camera; those of a
/// moving object are few, or close together. 0 if the determinant of the covariance is not
/// positive: its sigmas say nothing then.
double motionWorth(const PoseSolution& solution,
                   const std::vector<Correspondence>& correspondences);

/// Whether two motions predict most features at the same positions.
bool predictSamePositions(const StereoRig& rig, const ReferenceFrame& reference,
                          const Eigen::Isometry3d& T_a, const Eigen::Isometry3d& T_b);

/// The 0.9 quantile of the values, which are reordered; there must be at least one.
double highQuantile(std::vector<double>& values);

}  // namespace predictive_stereo
