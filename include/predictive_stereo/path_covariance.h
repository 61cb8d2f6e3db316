/// The covariance of a path that is composed of many estimated motions.
#pragma once

#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {

/// Effect on one motion of the calibration errors, which are the same in all frames. Each column is
/// the perturbation (translation [m], rotation [rad], see CameraMotion::covariance) that one
/// standard deviation of one error causes.
/// Columns: disparity offset; disparity errors that grow with x and with y; scale (baseline, focal
/// length); direction of the optical axis, about the camera's x and its y.
using CommonErrors = Eigen::Matrix<double, 6, 6>;

/// Covariance of a product of motions. Noise is independent from motion to motion: its standard
/// deviation grows with the square root of their number. Calibration errors are the same in all
/// motions: they grow with the number itself, or cancel on the way back.
class PathCovariance {
 public:
  /// Appends a motion to the path.
  /// @param motion  from the path's last frame to a new one. Its covariance contains noise and
  ///   calibration errors.
  /// @param common  the calibration errors' part of that covariance (common common^T).
  void add(const CameraMotion& motion, const CommonErrors& common) {
    // exp(e_step) T_step exp(e_path) T_path = exp(e_step + Ad e_path) T_step T_path.
    const Matrix6d A = adjoint(motion.T_cam_prev);
    noise_ = A * noise_ * A.transpose() + motion.covariance - common * common.transpose();
    common_ = A * common_ + common;
  }
  /// Of a left-multiplied perturbation (translation [m], rotation [rad]) of the product of all
  /// T_cam_prev, expressed in the last frame.
  Matrix6d covariance() const { return noise_ + common_ * common_.transpose(); }

 private:
  Matrix6d noise_ = Matrix6d::Zero();
  CommonErrors common_ = CommonErrors::Zero();
};

}  // namespace predictive_stereo
