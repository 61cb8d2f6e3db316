#pragma once

#include <functional>
#include <string>
#include <vector>

#include "evaluation/plot.h"
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
    double normalized_error;  ///< e'C^-1e / 6; NaN where the ego-motion was lost
    int features, inliers;
    double residual_px, ms;
  };
  std::vector<Motion> motions;
  Poses estimated, truth;  ///< both from the true first pose

  /// Over windows of several motions: root mean square errors, and e'C^-1e / 6, C being
  /// PathCovariance's.
  struct Window {
    int motions;
    double translation_m, rotation_rad;
    double mean_normalized, median_normalized;
    /// With the truth's jitter added to C: what windows of 5 motions are off by beyond their C. The
    /// jitter of poses is the same in windows of all lengths; errors of the odometry grow.
    double median_without_jitter;
  };
  std::vector<Window> windows;  ///< of 1, 2, 5, 10, 20 motions, as far as there are enough

  double length_m = 0;              ///< of the true path
  double length_error_percent = 0;  ///< of the estimated path's length
  MotionError mean, largest;
  std::vector<RelativePoseError> relative;  ///< over 5, 10, 20, 50, 100 m
  double mean_normalized_error = 0, median_normalized_error = 0;
  int lost = 0;
  double mean_ms = 0, median_ms = 0, p95_ms = 0;
};

/// What the ego-motion gets of a sequence.
struct OdometryInput {
  int max_frames = 0;  ///< 0: all
  int every = 1;       ///< every so many frames alone
  RotationPrior rotation_prior = RotationPrior::kNone;

  int frames(const Sequence& sequence) const;
};

/// @param progress  called after each frame with its index; may be empty.
/// @throws std::runtime_error for a sequence without true poses.
OdometryEvaluation evaluateOdometry(const Sequence& sequence, const EgoMotionParams& params,
                                    const OdometryInput& input,
                                    const std::function<void(int)>& progress);

/// Both paths, seen from above.
Plot pathPlot(const OdometryEvaluation& evaluation);

}  // namespace predictive_stereo
