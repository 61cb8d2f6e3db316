#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "predictive_stereo/rigid_motion.h"

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
class SimulatedGyro {
 public:
  static const std::vector<std::string>& kinds() {
    static const std::vector<std::string> kinds = {
        "none", "gyro", "opposite", "axes", "scaled", "biased", "stale", "zero", "random", "nan"};
    return kinds;
  }

  explicit SimulatedGyro(const std::string& kind)
      : kind_(kind), bias_axis_(sample().normalized()) {}

  /// @param T_cam_prev  the true motion since the previous frame, dt_s ago.
  /// @returns R_cam_prev of EgoMotion::estimate.
  std::optional<Eigen::Matrix3d> next(const Eigen::Isometry3d& T_cam_prev, double dt_s) {
    if (kind_ == "none") return std::nullopt;
    const Eigen::Matrix3d R = T_cam_prev.linear();
    const Eigen::Matrix3d R_before = std::exchange(R_before_, R);
    const Eigen::Vector3d noise_deg = kNoise_deg * std::sqrt(dt_s) * sample();
    const auto biased = [&](double bias_degps) -> Eigen::Matrix3d {
      return rotationBy(kRadPerDeg * (noise_deg + bias_degps * dt_s * bias_axis_)) * R;
    };
    if (kind_ == "gyro") return biased(kBias_degps);
    if (kind_ == "biased") return biased(kLargeBias_degps);
    if (kind_ == "opposite") return Eigen::Matrix3d(R.transpose());
    if (kind_ == "scaled") return Eigen::Matrix3d(R * R);
    if (kind_ == "stale") return R_before;
    if (kind_ == "random") return rotationBy(kRadPerDeg * kRandom_deg * sample().normalized());
    if (kind_ == "zero") return Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    if (kind_ == "nan") return Eigen::Matrix3d(Eigen::Matrix3d::Constant(std::nan("")));
    const Eigen::AngleAxisd turn(R);  // "axes"
    const Eigen::Vector3d w_rad = turn.angle() * turn.axis();
    return rotationBy({w_rad.y(), w_rad.z(), w_rad.x()});
  }

 private:
  static constexpr double kRadPerDeg = 3.14159265358979 / 180;
  static constexpr double kNoise_deg = 0.014;  // after one second: density in deg/s/sqrt(Hz)
  static constexpr double kBias_degps = 0.5, kLargeBias_degps = 30;
  static constexpr double kRandom_deg = 10;

  Eigen::Vector3d sample() {
    const double x = normal_(random_), y = normal_(random_), z = normal_(random_);
    return {x, y, z};
  }

  std::string kind_;
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
  Eigen::Vector3d bias_axis_;
  Eigen::Matrix3d R_before_ = Eigen::Matrix3d::Identity();
};

}  // namespace predictive_stereo
