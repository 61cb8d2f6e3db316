#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace predictive_stereo {

/// Simulates a sensor that gives the ego-motion its rotation prior: a gyroscope that measures the
/// true rotation, or a faulty one. Deterministic: the seed is fixed. Kinds:
///   none
///   gyro      a cheap MEMS gyroscope: 0.014 deg/s/sqrt(Hz), with a constant bias of 0.5 deg/s
///   opposite  wrong sign
///   axes      swapped axes: not mounted as tf says
///   scaled    twice the angle
///   biased    a bias of 30 deg/s
///   stale     the rotation of the previous frame
///   zero      always no rotation
///   random    10 deg about any axis
///   nan
class RotationPrior {
 public:
  static const std::vector<std::string>& kinds();

  /// @throws std::invalid_argument for an unknown kind; the message lists the known ones.
  explicit RotationPrior(const std::string& kind);

  /// @param T_cam_prev  the true motion since the previous frame, dt_s ago.
  /// @returns R_cam_prev of EgoMotion::estimate.
  std::optional<Eigen::Matrix3d> next(const Eigen::Isometry3d& T_cam_prev, double dt_s);

 private:
  Eigen::Vector3d sample();

  std::string kind_;
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
  Eigen::Vector3d bias_axis_;
  Eigen::Matrix3d R_before_ = Eigen::Matrix3d::Identity();
};

}  // namespace predictive_stereo
