/// How unlike the images are around a match.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Residuals are measured at every so many rows and columns.
constexpr int kResidualStep = 4;

/// Measures photometric residuals: the standard deviation of the difference between left and right
/// brightness over a window of matches. A constant difference, as of two exposures, is none. Keeps
/// its buffers between calls: maps of equal size allocate little.
class PhotometricResidual {
 public:
  /// @param right  whose rows are aligned with those of left; all inputs have one size, which is
  ///     not checked.
  /// @param principal_offset_px  cx_left - cx_right: the match of x is x - disparity - this.
  /// @param share  output, 0..1: how far the residual is above the median of the image, over the
  ///     contrast (standard deviation of the left image, + 1 grey level). 1: the images have
  ///     nothing in common. Element (x, y) is that of the window of 5x5 pixels, kResidualStep px
  ///     apart, around kResidualStep * (x, y). Pixels without a match inside the right image do not
  ///     count; a window without any other has the residual 0.
  void measure(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1f& disparity_px,
               const DisparityRange& range, double principal_offset_px, cv::Mat1f& share);

 private:
  /// Of a pixel or a window: matches; left - right, its square; left, its square.
  using Sums = cv::Vec<int, 5>;

  float medianResidual(const cv::Mat1f& residual);

  cv::Mat_<Sums> pixels_, windows_;
  std::vector<float> sample_;
};

}  // namespace predictive_stereo
