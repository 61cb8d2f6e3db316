#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <random>
#include <string>

#include "predictive_stereo/params.h"

namespace predictive_stereo {

/// What the ego-motion is told of the camera's rotation: the truth, seen by a gyroscope; or what
/// goes wrong with one.
enum class RotationPrior {
  kNone,
  kGyro,      ///< a cheap MEMS gyroscope, 0.014 deg/s/sqrt(Hz), whose bias of 0.5 deg/s stays
  kOpposite,  ///< the sign is wrong
  kAxes,      ///< the axes are exchanged: another mounting than tf says
  kScaled,    ///< twice as far
  kBiased,    ///< a bias of 30 deg/s
  kStale,     ///< the rotation of the frame before
  kZero,      ///< the sensor says that nothing turns
  kRandom,    ///< 10 deg about any axis
  kNan,
};
const Choices<RotationPrior>& rotationPriors();
/// @throws std::invalid_argument that lists the names there are.
RotationPrior rotationPriorByName(const std::string& name);

/// Makes such rotations of true motions. Deterministic: the seed is fixed.
class RotationPriorSource {
 public:
  explicit RotationPriorSource(RotationPrior kind);

  /// @param T_cam_prev  the true motion since the frame before, which took dt_s.
  /// @return as EgoMotion::estimate takes it.
  std::optional<Eigen::Matrix3d> next(const Eigen::Isometry3d& T_cam_prev, double dt_s);

 private:
  Eigen::Vector3d sample();

  RotationPrior kind_;
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
  Eigen::Vector3d bias_axis_;
  Eigen::Matrix3d R_before_ = Eigen::Matrix3d::Identity();
};

}  // namespace predictive_stereo
