#pragma once

#include "odometry/pose_solver.h"

namespace predictive_stereo {

/// Mean of the disparity offset over the last seconds, which averages the jitter of the cameras,
/// and the correction that is to be added to disparities.
///
/// The correction changes in steps: only when the mean is certain, and differs from it by more than
/// the errors of matching. Each step disturbs the stages that use the correction.
class SteadyOffset {
 public:
  /// @param offset  of a frame that was tracked.
  void update(const DisparityOffset& offset);

  /// Whether the mean is over enough frames.
  bool isCertain() const;
  double mean_px() const { return mean_px_; }
  double sigma_px() const { return sigma_px_; }
  /// 0 until the mean is certain.
  double correction_px() const { return correction_px_; }

 private:
  int frames_ = 0;     // of the mean
  double weight_ = 0;  // of the mean [1 / px^2]
  double mean_px_ = 0;
  double sigma_px_ = 0;
  double correction_px_ = 0;
};

}  // namespace predictive_stereo
