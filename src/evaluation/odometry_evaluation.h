#pragma once

#include <functional>
#include <string>
#include <vector>

#include "evaluation/plot.h"
#include "evaluation/pose_metrics.h"
#include "evaluation/sequence.h"
#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {

/// What was found out about ego-motion on one sequence with true poses.
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

  double length_m = 0;              ///< of the true path
  double length_error_percent = 0;  ///< of the estimated path's length
  MotionError mean, largest;
  std::vector<RelativePoseError> relative;  ///< over 5, 10, 20, 50, 100 m
  double mean_normalized_error = 0, median_normalized_error = 0;
  int lost = 0;
  double mean_ms = 0, median_ms = 0, p95_ms = 0;
};

/// @param max_frames  0: all.
/// @param progress  called after each frame with its index; may be empty.
/// @throws std::runtime_error for a sequence without true poses.
OdometryEvaluation evaluateOdometry(const Sequence& sequence, const EgoMotionParams& params,
                                    int max_frames, const std::function<void(int)>& progress);

/// Both paths, seen from above.
Plot pathPlot(const OdometryEvaluation& evaluation);

}  // namespace predictive_stereo
