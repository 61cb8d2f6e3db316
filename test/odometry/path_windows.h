/// Consistency of covariances of paths: errors over windows of several motions.
#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "evaluation/odometry_evaluation.h"
#include "evaluation/statistics.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {

/// e'C^-1e / 6 over windows of so many motions, where C is that of PathCovariance.
struct PathWindows {
  int motions;
  double mean_normalized;
  /// With the jitter of the true poses added to C. Its variance is the part of the squared errors
  /// over 5 motions that C does not explain: jitter is the same over windows of all lengths, while
  /// errors of the odometry grow.
  double median_without_jitter;
};

/// Error of a window of motions, and its estimated covariance.
struct WindowError {
  Vector6d error;
  Matrix6d covariance;

  double normalized(const Vector6d& jitter_variance) const {
    const Matrix6d C = covariance + Matrix6d(jitter_variance.asDiagonal());
    return error.dot(C.ldlt().solve(error)) / 6;
  }
};

inline std::vector<WindowError> windowErrors(const OdometryEvaluation& e, size_t motions) {
  std::vector<WindowError> errors;
  for (size_t first = 0; first + motions < e.truth.size(); ++first) {
    const size_t last = first + motions;
    PathCovariance path;
    bool tracked = true;
    for (size_t i = first + 1; i <= last; ++i) {
      const EgoMotionEstimate& estimate = e.estimates[i];
      tracked = tracked && estimate.state == PoseState::kKnown && estimate.frames == 1;
      path.add(estimate.motion, estimate.common_errors);
    }
    if (!tracked) continue;
    errors.push_back({perturbation(relative(e.estimated[last], e.estimated[first]),
                                   relative(e.truth[last], e.truth[first])),
                      path.covariance()});
  }
  return errors;
}

/// Windows of 1, 2, 5, 10, 20 motions, if the sequence is long enough.
inline std::vector<PathWindows> pathWindows(const OdometryEvaluation& e) {
  constexpr size_t kJitterWindow = 5;
  Vector6d jitter_variance = Vector6d::Zero();
  for (const WindowError& w : windowErrors(e, kJitterWindow))
    jitter_variance += w.error.cwiseAbs2() - w.covariance.diagonal();
  jitter_variance = (jitter_variance / static_cast<double>(e.truth.size() - kJitterWindow))
                        .cwiseMax(Vector6d::Zero());
  std::vector<PathWindows> windows;
  for (const size_t motions : {1, 2, 5, 10, 20}) {
    std::vector<double> normalized, without_jitter;
    for (const WindowError& w : windowErrors(e, motions)) {
      normalized.push_back(w.normalized(Vector6d::Zero()));
      without_jitter.push_back(w.normalized(jitter_variance));
    }
    if (!normalized.empty())
      windows.push_back(
          {static_cast<int>(motions), mean(normalized), nearestQuantile(without_jitter, 0.5)});
  }
  return windows;
}

}  // namespace predictive_stereo
