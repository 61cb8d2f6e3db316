#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <random>
#include <string>

#include "predictive_stereo/params.h"

namespace predictive_stereo {

/// The rotation prior of the ego-motion: the true rotation, measured by a gyroscope, or by a faulty
/// one.
enum class RotationPrior {
  kNone,
  kGyro,      ///< a cheap MEMS gyroscope: 0.014 deg/s/sqrt(Hz), with a constant bias of 0.5 deg/s
  kOpposite,  ///< wrong sign
  kAxes,      ///< swapped axes: not mounted as tf says
  kScaled,    ///< twice the angle
  kBiased,    ///< a bias of 30 deg/s
  kStale,     ///< the rotation of the previous frame
  kZero,      ///< always no rotation
  kRandom,    ///< 10 deg about any axis
  kNan,
};
const Choices<RotationPrior>& rotationPriors();
/// @throws std::invalid_argument for an unknown name; the message lists the known ones.
RotationPrior rotationPriorByName(const std::string& name);

/// Simulates such a sensor from true motions. Deterministic: the seed is fixed.
class RotationPriorSource {
 public:
  explicit RotationPriorSource(RotationPrior kind);

  /// @param T_cam_prev  the true motion since the previous frame, dt_s ago.
  /// @returns R_cam_prev of EgoMotion::estimate.
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
