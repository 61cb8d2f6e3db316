#include "odometry/steady_offset.h"

#include <algorithm>
#include <cmath>

namespace predictive_stereo {
namespace {

constexpr double kCertainPx = 0.1;  // largest sigma of a frame that is used
constexpr int kFewestFrames = 5;    // before the mean is used
constexpr int kMostFrames = 20;     // of the mean: two seconds
// The error of matching, and the change of the offset of real rigs from second to second.
constexpr double kStepPx = 0.25;

}  // namespace

void SteadyOffset::update(const DisparityOffset& offset) {
  if (!(offset.variance_px2 > 0) || offset.variance_px2 > kCertainPx * kCertainPx) return;
  const double information = 1 / offset.variance_px2;
  weight_ *= std::min(1.0, (kMostFrames - 1.0) / std::max(frames_, 1));
  frames_ = std::min(frames_ + 1, kMostFrames);
  weight_ += information;
  mean_px_ += information / weight_ * (offset.offset_px - mean_px_);
  // Errors of successive frames are correlated: the mean is only as certain as one frame.
  sigma_px_ = std::sqrt(offset.variance_px2);
  if (isCertain() && std::abs(mean_px_ - correction_px_) > std::max(kStepPx, 3 * sigma_px_))
    correction_px_ = mean_px_;
}

bool SteadyOffset::isCertain() const { return frames_ >= kFewestFrames; }

}  // namespace predictive_stereo
