#pragma once

#include <string>
#include <vector>

#include "evaluation/pose_metrics.h"
#include "evaluation/rotation_prior.h"
#include "evaluation/sequence.h"
#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {

/// Errors of the ego-motion on one sequence with true poses.
struct OdometryEvaluation {
  std::string name;
  struct Motion {
    int frame;  ///< the later one of its two frames
    bool tracked;
    MotionError error;
    double normalized_error;  ///< e'C^-1e / 6; NaN if the ego-motion was lost
    int features, inliers;
    double residual_px, ms;
  };
  std::vector<Motion> motions;
  Poses estimated, truth;  ///< both start at the true first pose

  /// Over windows of several motions: root mean square errors, and e'C^-1e / 6, where C is that of
  /// PathCovariance.
  struct Window {
    int motions;
    double translation_m, rotation_rad;
    double mean_normalized, median_normalized;
    /// With the jitter of the true poses added to C. Its variance is the part of the squared errors
    /// over 5 motions that C does not explain: jitter is the same over windows of all lengths,
    /// while errors of the odometry grow.
    double median_without_jitter;
  };
  std::vector<Window> windows;  ///< of 1, 2, 5, 10, 20 motions, if the sequence is long enough

  double length_m = 0;              ///< of the true path
  double length_error_percent = 0;  ///< of the estimated path's length
  MotionError mean, largest;
  std::vector<RelativePoseError> relative;  ///< over 5, 10, 20, 50, 100 m
  double mean_normalized_error = 0, median_normalized_error = 0;
  int lost = 0;
  double mean_ms = 0, median_ms = 0, p95_ms = 0;
};

/// The part of a sequence that the ego-motion gets, and its rotation prior.
struct OdometryInput {
  int max_frames = 0;  ///< 0: all
  int every = 1;       ///< only every n-th frame
  RotationPrior rotation_prior = RotationPrior::kNone;

  int frames(const Sequence& sequence) const;
};

/// @throws std::runtime_error for a sequence without true poses.
OdometryEvaluation evaluateOdometry(const Sequence& sequence, const EgoMotionParams& params,
                                    const OdometryInput& input = {});

/// True and estimated positions of each frame, in the first camera's axes.
std::string pathsCsv(const std::vector<OdometryEvaluation>& evaluations);

}  // namespace predictive_stereo
