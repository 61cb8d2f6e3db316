#pragma once

#include <opencv2/core.hpp>

namespace predictive_stereo {

/// Where in the image errors are: absolute errors, accumulated (the paper's figure 3).
class ErrorImage {
 public:
  static constexpr int kCell_px =
      4;  ///< laser points are sparse: cells of so many rows and columns

  /// Of no size; whatever is added is dropped.
  ErrorImage() = default;
  explicit ErrorImage(cv::Size size);

  void add(double x_px, double y_px, double error_px);
  /// Sum of absolute errors of the cell that holds this pixel [px].
  double sum_px(int x_px, int y_px) const { return sums_px_(y_px / kCell_px, x_px / kCell_px); }

  /// White, and the bluer the larger the sum of the cell is. From the 99th percentile of the cells
  /// with errors on it is pure blue.
  cv::Mat3b picture() const;

 private:
  cv::Size size_;
  cv::Mat1d sums_px_;  ///< one a cell
};

}  // namespace predictive_stereo
