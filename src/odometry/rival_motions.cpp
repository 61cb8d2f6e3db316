#include "odometry/rival_motions.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {
namespace {

constexpr double kSamePlacePx = 2;  // tracking finds features from much farther away
constexpr double kFarPx = 1e6;      // also replaces NaN, of points beside the camera

}  // namespace

double motionWorth(const PoseSolution& solution,
                   const std::vector<Correspondence>& correspondences) {
  double support = 0;
  for (size_t i = 0; i < correspondences.size(); ++i)
    if (solution.inlier[i]) support += correspondences[i].trust;
  const double determinant = solution.covariance.determinant();
  return determinant > 0 ? support / std::pow(determinant, 1.0 / 12) : 0;
}

bool predictSamePositions(const StereoRig& rig, const ReferenceFrame& reference,
                          const Eigen::Isometry3d& T_a, const Eigen::Isometry3d& T_b) {
  const Eigen::Matrix4d by_a = disparityMotion(rig, T_a), by_b = disparityMotion(rig, T_b);
  std::vector<double> apart_px;
  for (const Feature& feature : reference.features) {
    const Eigen::Vector4d point(feature.position.x, feature.position.y,
                                feature.disparity_px + reference.offset.offset_px, 1);
    const double px =
        ((by_a * point).hnormalized() - (by_b * point).hnormalized()).head<2>().norm();
    apart_px.push_back(std::min(kFarPx, px));
  }
  return highQuantile(apart_px) < kSamePlacePx;
}

double highQuantile(std::vector<double>& values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 9 / 10);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace predictive_stereo
