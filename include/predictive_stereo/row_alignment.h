/// Row alignment: rectified pairs are not rectified well enough for census costs.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

struct RowAlignmentParams {
  bool enabled = true;
  int min_samples = 100;       ///< fewer samples in agreement: identity
  double max_offset_px = 3.0;  ///< a fit that exceeds this anywhere is refused: identity
  double smoothing = 0.5;      ///< weight of the past frames' offsets, 0: each frame by itself

  template <class Visitor>
  void visit(Visitor&& v) {
    v("enabled", enabled);
    v("min_samples", min_samples, 12, 100000);
    v("max_offset_px", max_offset_px, 0.5, 10.0);
    v("smoothing", smoothing, 0.0, 0.99);
  }
};

/// The vertical offset between the images of a pair: a point seen in row y of the left image lies
/// in row y + offset(x, y) of the right one, where (x, y) are coordinates of the **left** image:
/// offset = c0 + c1 u + c2 v + c3 u^2 + c4 u v + c5 v^2, u = 2x / width - 1, v = 2y / height - 1.
struct RowAlignment {
  Eigen::Matrix<double, 6, 1> coefficients_px = Eigen::Matrix<double, 6, 1>::Zero();
  int samples = 0;               ///< samples in agreement with the fit; 0: identity
  double residual_px = 0;        ///< their root mean square residual
  double largest_offset_px = 0;  ///< largest |offset| over the image: the calibration's health

  bool isIdentity() const { return samples == 0; }
  double offset(double x_px, double y_px, cv::Size size) const;
};

/// Estimates the offset in every frame, smoothed over the past frames.
class RowAligner {
 public:
  explicit RowAligner(const RowAlignmentParams& params);

  /// @param coarse_disparity_px  the half-resolution match of this pair (CoarseMatcher).
  /// Identity where switched off, or where samples are too few or do not agree.
  RowAlignment estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                        const cv::Mat1f& coarse_disparity_px, const DisparityRange& range);
  void reset();

 private:
  RowAlignmentParams params_;
  RowAlignment past_;
};

/// Moves the right image vertically, so that its rows are those of the left image, and by
/// `column_shift_px` to the right, so that principal points that differ cost nothing later on
/// (linear interpolation, borders replicated). Where nothing is to be moved nothing is copied:
/// `aligned` then shares the pixels of `right`.
void alignRightImage(const cv::Mat1b& right, const RowAlignment& alignment, double column_shift_px,
                     cv::Mat1b& aligned);

}  // namespace predictive_stereo
