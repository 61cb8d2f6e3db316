#include "evaluation/rotation_prior.h"

#include <algorithm>
#include <boost/algorithm/string/join.hpp>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr double kRadPerDeg = 3.14159265358979 / 180;
constexpr double kNoise_deg = 0.014;  // after one second: density in deg/s/sqrt(Hz)
constexpr double kBias_degps = 0.5, kLargeBias_degps = 30;
constexpr double kRandom_deg = 10;

}  // namespace

const std::vector<std::string>& RotationPrior::kinds() {
  static const std::vector<std::string> kinds = {"none",   "gyro",  "opposite", "axes",   "scaled",
                                                 "biased", "stale", "zero",     "random", "nan"};
  return kinds;
}

RotationPrior::RotationPrior(const std::string& kind)
    : kind_(kind), bias_axis_(sample().normalized()) {
  if (std::find(kinds().begin(), kinds().end(), kind) == kinds().end())
    throw std::invalid_argument("--rotation-prior " + kind + ": must be one of " +
                                boost::algorithm::join(kinds(), " | "));
}

std::optional<Eigen::Matrix3d> RotationPrior::next(const Eigen::Isometry3d& T_cam_prev,
                                                   double dt_s) {
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

Eigen::Vector3d RotationPrior::sample() {
  const double x = normal_(random_), y = normal_(random_), z = normal_(random_);
  return {x, y, z};
}

}  // namespace predictive_stereo
