/// How motions are compared that compete for one frame.
#pragma once

#include <vector>

#include "odometry/pose_solver.h"
#include "odometry/reference_frame.h"

namespace predictive_stereo {

/// How likely static the points are, in all, that agree with a motion.
double support(const PoseSolution& solution, const std::vector<Correspondence>& correspondences);

/// Whether a motion is to be preferred to another one, with their support. Of two that are
/// supported alike, the one that its points determine better: the static world surrounds the
/// camera, but what moves together is in few places.
bool isPreferred(const PoseSolution& a, double support_a, const PoseSolution& b, double support_b);

/// Whether two motions expect most features at the same places.
bool predictSamePositions(const StereoRig& rig, const ReferenceFrame& reference,
                          const Eigen::Isometry3d& T_a, const Eigen::Isometry3d& T_b);

/// The 0.9 quantile of values, at least one, which are reordered.
double highQuantile(std::vector<double>& values);

}  // namespace predictive_stereo
