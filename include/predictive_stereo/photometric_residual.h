/// How unlike both images are around a match.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Measures photometric residuals: the standard deviation of the difference between left and right
/// brightness over a window of matches. A constant difference, as of two exposures, is none. Keeps
/// its buffers between calls: maps of equal size allocate little.
class PhotometricResidual {
 public:
  /// @param right  whose rows are aligned with those of left; all inputs have one size, which is
  ///     not checked.
  /// @param principal_offset_px  cx_left - cx_right: the match of x is x - disparity - this.
  /// @param excess  output of half the size, rounded up: how far the residual [grey levels] of
  /// every
  ///     second row and column is above the median of the image. Each window has 5x5 of these
  ///     pixels; those without a match inside the right image do not count. A window without any
  ///     has the residual 0.
  void measure(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1f& disparity_px,
               const DisparityRange& range, double principal_offset_px, cv::Mat1f& excess);

 private:
  float median(const cv::Mat1f& residual);

  cv::Mat3f differences_, sums_;  ///< of each pixel and window: matches, difference, its square
  std::vector<float> sample_;
};

}  // namespace predictive_stereo
