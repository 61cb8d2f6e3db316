#include "evaluation/pose_metrics.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>

#include "evaluation/statistics.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

void requireEqual(size_t estimated, size_t truth) {
  if (estimated != truth)
    throw std::invalid_argument(std::to_string(estimated) + " estimated and " +
                                std::to_string(truth) +
                                " true poses or motions: give as many of each");
}

double angle(const Eigen::Matrix3d& rotation) { return Eigen::AngleAxisd(rotation).angle(); }

}  // namespace

MotionError motionError(const Eigen::Isometry3d& estimated, const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d difference = relative(estimated, truth);
  return {difference.translation().norm(), angle(difference.linear())};
}

MotionError meanMotionError(const Poses& estimated, const Poses& truth) {
  requireEqual(estimated.size(), truth.size());
  MotionError sum;
  for (size_t i = 1; i < truth.size(); ++i) {
    const MotionError error =
        motionError(relative(estimated[i], estimated[i - 1]), relative(truth[i], truth[i - 1]));
    sum.translation_m += error.translation_m;
    sum.rotation_rad += error.rotation_rad;
  }
  return {ratio(sum.translation_m, truth.size() - 1), ratio(sum.rotation_rad, truth.size() - 1)};
}

std::vector<RelativePoseError> relativePoseErrors(const Poses& estimated, const Poses& truth,
                                                  const std::vector<double>& lengths_m) {
  requireEqual(estimated.size(), truth.size());
  std::vector<double> travelled_m(truth.size(), 0.0);
  for (size_t i = 1; i < truth.size(); ++i)
    travelled_m[i] =
        travelled_m[i - 1] + (truth[i].translation() - truth[i - 1].translation()).norm();
  std::vector<RelativePoseError> errors;
  for (const double length_m : lengths_m) {
    RelativePoseError error;
    error.length_m = length_m;
    for (size_t first = 0, last = 0; first < truth.size(); ++first) {
      while (last < truth.size() && travelled_m[last] < travelled_m[first] + length_m) ++last;
      if (last == truth.size()) break;
      const MotionError difference = motionError(relative(estimated[first], estimated[last]),
                                                 relative(truth[first], truth[last]));
      error.translation_percent += 100 * difference.translation_m / length_m;
      error.rotation_deg_per_m += difference.rotation_rad * 180 / M_PI / length_m;
      ++error.stretches;
    }
    if (error.stretches) {
      error.translation_percent /= error.stretches;
      error.rotation_deg_per_m /= error.stretches;
    }
    errors.push_back(error);
  }
  return errors;
}

Vector6d perturbation(const Eigen::Isometry3d& estimated, const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d difference = compose(truth, estimated.inverse());
  const Eigen::AngleAxisd rotation(difference.linear());
  Vector6d error;
  error << difference.translation(), rotation.angle() * rotation.axis();
  return error;
}

double normalizedErrorSquared(const CameraMotion& estimated, const Eigen::Isometry3d& truth) {
  const Vector6d error = perturbation(estimated.T_cam_prev, truth);
  const Eigen::LLT<Matrix6d> cholesky(estimated.covariance);
  if (cholesky.info() != Eigen::Success)
    throw std::invalid_argument("normalizedErrorSquared: the covariance must be positive definite");
  return error.dot(cholesky.solve(error));
}

}  // namespace predictive_stereo
