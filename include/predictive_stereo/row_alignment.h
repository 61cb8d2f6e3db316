/// Row alignment: rectified pairs are not rectified well enough for census costs.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"

namespace predictive_stereo {

struct RowAlignmentParams {
  bool enabled = true;
  int min_samples = 100;       ///< fewer samples in agreement: identity
  double max_offset_px = 3.0;  ///< a fit that exceeds this anywhere is refused: identity
  double smoothing = 0.8;      ///< weight of a frame's samples in the next frame, 0: none

  template <class Visitor>
  void visit(Visitor&& v) {
    v("enabled", enabled);
    v("min_samples", min_samples, 12, 100000);
    v("max_offset_px", max_offset_px, 0.5, 10.0);
    v("smoothing", smoothing, 0.0, 0.99);
  }
};

/// The vertical offset between the images of a pair: a point seen in row y of the left image and
/// in column x of the **right** one lies in row y + offset(x, y) of the right one,
/// offset = c0 + c1 u + c2 v + c3 u^2 + c4 u v + c5 v^2, u = 2x / width - 1, v = 2y / height - 1.
///
/// It is a function of the right image's columns because it can then be undone without knowing
/// disparities; it fits real rigs as well as one of the left image's columns does. Where no
/// disparity is known the left column may stand in: on KITTI that errs by 0.1 px at most.
struct RowOffsetModel {
  Eigen::Matrix<double, 6, 1> coefficients_px = Eigen::Matrix<double, 6, 1>::Zero();
  int samples = 0;               ///< samples in agreement with the fit; 0: identity
  double residual_px = 0;        ///< their root mean square residual
  double rms_offset_px = 0;      ///< root mean square offset over the image
  double largest_offset_px = 0;  ///< largest |offset| over the image: the calibration's health

  bool isIdentity() const { return samples == 0; }
  double offset(double x_right_px, double y_px, cv::Size size) const;
  /// The offsets of a row, c0 + c1 x + c2 x^2 at column x.
  Eigen::Vector3d alongRow(double y_px, cv::Size size) const;
};

/// One measurement of the offset, at column x of the right image and row y of the left one.
struct RowOffsetMeasurement {
  double x_right_px;
  double y_px;
  double offset_px;
};

/// Fits the six terms robustly to the samples of a frame and, with a weight that fades, to those of
/// the past frames: a frame that shows little is then aligned by what was seen before. The
/// constant term alone is taken from the present frame: it shakes on real rigs.
class RowOffsetFilter {
 public:
  /// @throws std::invalid_argument for parameters outside their limits.
  explicit RowOffsetFilter(const RowAlignmentParams& params);
  /// From the next frame on; the past frames are kept. Throws as the constructor does.
  void setParams(const RowAlignmentParams& params);

  /// @return identity where samples are too few or do not agree, now and in the past frames.
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

/// Estimates the offset in every frame: small patches with texture, one in every few pixels of the
/// half-resolution match, are looked for some rows up and down in the right image.
class RowAligner {
 public:
  /// @throws std::invalid_argument for parameters outside their limits.
  explicit RowAligner(const RowAlignmentParams& params);
  /// From the next frame on; the past frames are kept. Throws as the constructor does.
  void setParams(const RowAlignmentParams& params);

  /// @param left, right  8-bit grey images of one size.
  /// @param coarse_disparity_px  the half-resolution match of this pair (CoarseMatcher).
  /// @return identity where switched off, or where samples are too few or do not agree.
  /// @throws std::invalid_argument for sizes that do not fit together.
  RowOffsetModel estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                          const cv::Mat1f& coarse_disparity_px, const DisparityRange& range);
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

/// Moves the right image vertically, so that its rows are those of the left image, and by
/// `column_shift_px` to the right, so that principal points that differ cost nothing later on
/// (linear interpolation to 1/128 px, borders replicated). The alignment's columns are those after
/// the shift.
///
/// Where nothing is to be moved nothing is copied: `aligned` then shares the pixels of `right`.
/// Otherwise its memory is reused, unless somebody else shares it.
void alignRightImage(const cv::Mat1b& right, const RowOffsetModel& alignment,
                     double column_shift_px, cv::Mat1b& aligned);

}  // namespace predictive_stereo
