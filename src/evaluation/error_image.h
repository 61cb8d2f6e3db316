#pragma once

#include <opencv2/core.hpp>

namespace predictive_stereo {

/// Distribution of errors over the image: accumulated absolute errors (the paper's figure 3).
class ErrorImage {
 public:
  static constexpr int kCell_px = 4;  ///< rows and columns of a cell; laser points are sparse

  /// An empty image, which drops everything that is added.
  ErrorImage() = default;
  explicit ErrorImage(cv::Size size);

  void add(double x_px, double y_px, double error_px);
  /// Sum of absolute errors [px] of the cell that contains this pixel.
  double sum_px(int x_px, int y_px) const { return sums_px_(y_px / kCell_px, x_px / kCell_px); }

  /// From white (0) to pure blue (99th percentile of the cells with errors, and above).
  cv::Mat3b picture() const;

 private:
  cv::Size size_;
  cv::Mat1d sums_px_;  ///< one per cell
};

}  // namespace predictive_stereo
