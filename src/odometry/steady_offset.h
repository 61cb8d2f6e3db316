#pragma once

#include "odometry/pose_solver.h"

namespace predictive_stereo {

/// What stays of the disparity offset while the cameras shake: its mean over the last seconds, and
/// the part of it that disparities are to be corrected by.
///
/// The correction changes in steps, because each of them costs those who use it their steady state:
/// only when the mean is certain, and further from it than matching errs anyway.
class SteadyOffset {
 public:
  /// @param offset  of a frame that was tracked.
  void update(const DisparityOffset& offset);

  /// Whether enough frames were certain.
  bool isCertain() const;
  double mean_px() const { return mean_px_; }
  double sigma_px() const { return sigma_px_; }
  /// 0 until the mean is certain.
  double correction_px() const { return correction_px_; }

 private:
  int frames_ = 0;     // that were certain, up to those of the mean
  double weight_ = 0;  // of the mean so far [1 / px^2]
  double mean_px_ = 0;
  double sigma_px_ = 0;
  double correction_px_ = 0;
};

}  // namespace predictive_stereo
