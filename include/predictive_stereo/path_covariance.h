/// How uncertain a path is that is made of many estimated motions.
#pragma once

#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {

/// What errors that all frames have in common do to one motion: each column is the perturbation
/// (as CameraMotion::covariance describes it) by one standard deviation of one error.
/// Columns: disparity offset; disparity errors that grow with x and with y; scale (baseline, focal
/// length); direction of the optical axis, about the camera's x and its y.
using CommonErrors = Eigen::Matrix<double, 6, 6>;

/// Covariance of a product of motions. Noise is independent from motion to motion and grows with
/// the square root of their number; errors of the calibration are the same in all motions and grow
/// with the number itself, or cancel on the way back.
class PathCovariance {
 public:
  /// Makes the path longer by a motion.
  /// @param motion  its covariance is that of both kinds of errors.
  void add(const CameraMotion& motion, const CommonErrors& common);
  /// Of a left-multiplied perturbation of the product of all T_cam_prev, expressed in the last
  /// frame.
  Matrix6d covariance() const { return noise_ + common_ * common_.transpose(); }

 private:
  Matrix6d noise_ = Matrix6d::Zero();
  CommonErrors common_ = CommonErrors::Zero();
};

}  // namespace predictive_stereo
