/// Row alignment: measures and removes the vertical offset that remains between rectified images.
/// Census costs do not tolerate it.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"

namespace predictive_stereo {

struct RowAlignmentParams {
  bool enabled = true;
  int min_samples = 100;       ///< with fewer inliers the model is identity
  double max_offset_px = 3.0;  ///< a fit that exceeds this anywhere is rejected: identity
  double smoothing = 0.8;      ///< weight of past samples, per frame; 0: past frames are not used

  template <class Visitor>
  void visit(Visitor&& v) {
    v("enabled", enabled);
    v("min_samples", min_samples, 12, 100000);
    v("max_offset_px", max_offset_px, 0.5, 10.0);
    v("smoothing", smoothing, 0.0, 0.99);
  }
};

/// The vertical offset between the images of a pair: a point in row y of the left image and in
/// column x of the **right** one is in row y + offset(x, y) of the right one,
/// offset = c0 + c1 u + c2 v + c3 u^2 + c4 u v + c5 v^2, u = 2x / width - 1, v = 2y / height - 1.
///
/// It is a function of the right image's columns, as it can then be removed without known
/// disparities. It fits real rigs as well as a function of the left image's columns does. Where no
/// disparity is known, use the left column instead: on KITTI the error is 0.1 px at most.
struct RowOffsetModel {
  Eigen::Matrix<double, 6, 1> coefficients_px = Eigen::Matrix<double, 6, 1>::Zero();  ///< c0 ... c5
  int samples = 0;               ///< inliers of the fit; 0: identity
  double residual_px = 0;        ///< their root mean square residual
  double rms_offset_px = 0;      ///< root mean square offset over the image
  double largest_offset_px = 0;  ///< largest |offset| over the image; large: poor calibration

  bool isIdentity() const { return samples == 0; }
  /// Offset [px] at column x_right_px of the right image and row y_px of the left one.
  /// @param size  of the images [px], not empty.
  double offset(double x_right_px, double y_px, cv::Size size) const;
  /// Coefficients (c0, c1, c2) of the offset along row y_px: c0 + c1 x + c2 x^2 [px] at column x of
  /// the right image.
  /// @param size  of the images [px], not empty.
  Eigen::Vector3d alongRow(double y_px, cv::Size size) const;
};

/// One measurement of the offset, at column x_right_px of the right image and row y_px of the left
/// one.
struct RowOffsetMeasurement {
  double x_right_px;
  double y_px;
  double offset_px;
};

/// Fits the six terms robustly to the samples of a frame and, with exponentially decreasing weight,
/// of the past frames: a frame with few samples is then aligned by the earlier ones. Only the
/// constant term is fitted to the current frame alone, as it changes from frame to frame on real
/// rigs.
class RowOffsetFilter {
 public:
  /// @throws std::invalid_argument if a parameter is outside its limits.
  explicit RowOffsetFilter(const RowAlignmentParams& params);
  /// Sets parameters for the next frame. The past frames are kept.
  /// @throws std::invalid_argument as the constructor does; the parameters are then unchanged.
  void setParams(const RowAlignmentParams& params);

  /// Adds the samples of a frame.
  /// @param size  of the images [px], not empty.
  /// @returns identity if there are too few inliers in this and the past frames, or if the fit
  ///   exceeds max_offset_px.
  RowOffsetModel update(const std::vector<RowOffsetMeasurement>& samples, cv::Size size);
  /// Forgets the past frames.
  void reset();

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  // Normal equations of a weighted least-squares fit.
  struct Fit {
    Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
    Vector6 weighted_offset = Vector6::Zero();
    double samples = 0;
    double squared_residuals = 0;

    void fade(double weight);
    void add(const Fit& other);
  };
  Vector6 solve(const Fit& fit) const;

  RowAlignmentParams params_;
  Fit past_;
  Vector6 prior_px_ = Vector6::Zero();
  std::vector<Vector6> terms_;
};

/// Estimates the offset in every frame: small textured patches on a grid are searched some rows up
/// and down in the right image, at the disparity of the half-resolution match.
class RowAligner {
 public:
  /// @throws std::invalid_argument if a parameter is outside its limits.
  explicit RowAligner(const RowAlignmentParams& params);
  /// Sets parameters for the next frame. The past frames are kept.
  /// @throws std::invalid_argument as the constructor does; the parameters are then unchanged.
  void setParams(const RowAlignmentParams& params);

  /// @param left, right  rectified 8-bit grey images of one size.
  /// @param coarse_disparity_px  the half-resolution match of this pair (CoarseMatcher), of size
  ///   (width / 2, height / 2).
  /// @param range  of that match, in pixels of the full resolution.
  /// @param principal_offset_px  see StereoRig::principalOffset.
  /// @returns identity if not params.enabled, or as RowOffsetFilter::update does.
  /// @throws std::invalid_argument if the images are empty or differ in size, or if
  ///   coarse_disparity_px does not have half their size.
  RowOffsetModel estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                          const cv::Mat1f& coarse_disparity_px, const DisparityRange& range,
                          double principal_offset_px = 0);
  /// Forgets the past frames.
  void reset();

 private:
  struct Tried {
    RowOffsetMeasurement sample;
    bool valid;
  };

  RowAlignmentParams params_;
  RowOffsetFilter filter_;
  std::vector<Tried> tried_;
  std::vector<RowOffsetMeasurement> samples_;
};

/// Warps the right image: vertically, so that its rows are those of the left image, and by
/// `column_shift_px` to the right, which loses as many columns. Linear interpolation to 1/128 px;
/// border pixels are replicated.
/// @param alignment  its columns are those after the shift.
/// @param column_shift_px  for small errors of the calibration; see StereoMatcher for principal
///   points that differ.
/// @param aligned  output of the size of `right`. Without any motion it shares the pixels of
///   `right`. Otherwise its memory is reused if no other cv::Mat shares it.
void alignRightImage(const cv::Mat1b& right, const RowOffsetModel& alignment,
                     double column_shift_px, cv::Mat1b& aligned);

}  // namespace predictive_stereo
