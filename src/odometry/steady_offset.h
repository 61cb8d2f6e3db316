#pragma once

#include <algorithm>
#include <cmath>

#include "odometry/pose_solver.h"
#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {

/// Mean of the disparity offset over the last seconds, which averages the jitter of the cameras,
/// and the correction that is to be added to disparities.
///
/// The correction changes in steps: only when the mean is certain, and differs from it by more than
/// the errors of matching. Each step disturbs the stages that use the correction.
class SteadyOffset {
 public:
  /// @param offset  of a frame that was tracked.
  void update(const DisparityOffset& offset) {
    if (!(offset.variance_px2 > 0) || offset.variance_px2 > kCertainPx * kCertainPx) return;
    const double information = 1 / offset.variance_px2;
    weight_ *= std::min(1.0, (kMostFrames - 1.0) / std::max(frames_, 1));
    frames_ = std::min(frames_ + 1, kMostFrames);
    weight_ += information;
    auto& [known, mean_px, sigma_px, correction_px] = column_;
    mean_px += information / weight_ * (offset.offset_px - mean_px);
    // Errors of successive frames are correlated: the mean is only as certain as one frame.
    sigma_px = std::sqrt(offset.variance_px2);
    known = frames_ >= kFewestFrames;
    if (known && std::abs(mean_px - correction_px) > std::max(kStepPx, 3 * sigma_px))
      correction_px = mean_px;
  }

  /// Known once the mean is over enough frames.
  const ColumnOffset& column() const { return column_; }

 private:
  static constexpr double kCertainPx = 0.1;  // largest sigma of a frame that is used
  static constexpr int kFewestFrames = 5;    // before the mean is used
  static constexpr int kMostFrames = 20;     // of the mean: two seconds
  // The error of matching, and the change of the offset of real rigs from second to second.
  static constexpr double kStepPx = 0.25;

  int frames_ = 0;     // of the mean
  double weight_ = 0;  // of the mean [1 / px^2]
  ColumnOffset column_;
};

}  // namespace predictive_stereo
