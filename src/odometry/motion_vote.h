#pragma once

#include <vector>

#include "odometry/pose_model.h"

namespace predictive_stereo {

/// The motion that most correspondences agree with: RANSAC on three points, with a fixed seed and a
/// truncated quadratic cost (MSAC), weighted by trust. Does not depend on the number of threads.
/// @param correspondences  at least one.
/// @param T_expected  competes with the random hypotheses, which start from it.
/// @param offset_px  of the disparities of both frames.
Eigen::Isometry3d voteForMotion(const StereoRig& rig,
                                const std::vector<Correspondence>& correspondences,
                                const Eigen::Isometry3d& T_expected, double offset_px,
                                const CoarseNoise& noise, int max_hypotheses);

}  // namespace predictive_stereo
