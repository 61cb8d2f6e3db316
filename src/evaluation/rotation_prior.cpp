#include "evaluation/rotation_prior.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr double kRadPerDeg = 3.14159265358979 / 180;
constexpr double kNoise_deg = 0.014;  // after one second: density in deg/s/sqrt(Hz)
constexpr double kBias_degps = 0.5, kLargeBias_degps = 30;
constexpr double kRandom_deg = 10;

}  // namespace

const Choices<RotationPrior>& rotationPriors() {
  static const Choices<RotationPrior> priors = {
      {"none", RotationPrior::kNone},         {"gyro", RotationPrior::kGyro},
      {"opposite", RotationPrior::kOpposite}, {"axes", RotationPrior::kAxes},
      {"scaled", RotationPrior::kScaled},     {"biased", RotationPrior::kBiased},
      {"stale", RotationPrior::kStale},       {"zero", RotationPrior::kZero},
      {"random", RotationPrior::kRandom},     {"nan", RotationPrior::kNan}};
  return priors;
}

RotationPrior rotationPriorByName(const std::string& name) {
  std::string names;
  for (const auto& prior : rotationPriors()) {
    if (name == prior.first) return prior.second;
    names += (names.empty() ? "" : " | ") + std::string(prior.first);
  }
  throw std::invalid_argument("--rotation-prior " + name + ": must be one of " + names);
}

RotationPriorSource::RotationPriorSource(RotationPrior kind)
    : kind_(kind), bias_axis_(sample().normalized()) {}

std::optional<Eigen::Matrix3d> RotationPriorSource::next(const Eigen::Isometry3d& T_cam_prev,
                                                         double dt_s) {
  const Eigen::Matrix3d R = T_cam_prev.linear();
  const Eigen::Matrix3d R_before = R_before_;
  R_before_ = R;
  const Eigen::Vector3d noise_deg = kNoise_deg * std::sqrt(dt_s) * sample();
  const auto biased = [&](double bias_degps) -> Eigen::Matrix3d {
    return rotationBy(kRadPerDeg * (noise_deg + bias_degps * dt_s * bias_axis_)) * R;
  };
  switch (kind_) {
    case RotationPrior::kNone:
      return std::nullopt;
    case RotationPrior::kGyro:
      return biased(kBias_degps);
    case RotationPrior::kOpposite:
      return Eigen::Matrix3d(R.transpose());
    case RotationPrior::kAxes: {
      const Eigen::AngleAxisd turn(R);
      const Eigen::Vector3d w_rad = turn.angle() * turn.axis();
      return rotationBy({w_rad.y(), w_rad.z(), w_rad.x()});
    }
    case RotationPrior::kScaled:
      return Eigen::Matrix3d(R * R);
    case RotationPrior::kBiased:
      return biased(kLargeBias_degps);
    case RotationPrior::kStale:
      return R_before;
    case RotationPrior::kZero:
      return Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    case RotationPrior::kRandom:
      return rotationBy(kRadPerDeg * kRandom_deg * sample().normalized());
    case RotationPrior::kNan:
      return Eigen::Matrix3d(Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
  return std::nullopt;
}

Eigen::Vector3d RotationPriorSource::sample() {
  const double x = normal_(random_), y = normal_(random_), z = normal_(random_);
  return {x, y, z};
}

}  // namespace predictive_stereo
