#include "predictive_stereo/path_covariance.h"

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {

void PathCovariance::add(const CameraMotion& motion, const CommonErrors& common) {
  // exp(e_step) T_step exp(e_path) T_path = exp(e_step + Ad e_path) T_step T_path.
  const Matrix6d A = adjoint(motion.T_cam_prev);
  noise_ = A * noise_ * A.transpose() + motion.covariance - common * common.transpose();
  common_ = A * common_ + common;
}

}  // namespace predictive_stereo
