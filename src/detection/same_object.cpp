#include "detection/same_object.h"

#include <algorithm>
#include <cmath>

#include "detection/constants.h"

namespace predictive_stereo {

double intersectionOverUnion(const cv::Rect2d& a, const cv::Rect2d& b) {
  const double both = (a & b).area();
  return both / std::max(a.area() + b.area() - both, 1e-9);
}

bool overlaps(const MotionDetectionParams& params, const Observation& seen,
              const Observation& object) {
  const cv::Rect common = object.box_px & seen.box_px;
  return common.area() > 0.5 * std::min(object.box_px.area(), seen.box_px.area()) &&
         std::abs(object.distance_m - seen.distance_m) < params.max_width_m / 2;
}

bool belongsTo(const Observation& seen, const Observation& object, double largest_share) {
  constexpr double kSigma_mps = 2, kMostSigmas = 3;  // for sides, whose motion along them is vague
  constexpr double kDepthGap_m = 4.5, kMostHidden = 0.3;
  const int gap_px =
      static_cast<int>(DetectionConstants::kGap_m / object.size_m.x() * object.box_px.width) + 8;
  const cv::Rect around(object.box_px.x - gap_px, object.box_px.y - gap_px,
                        object.box_px.width + 2 * gap_px, object.box_px.height + 2 * gap_px);
  if ((around & seen.box_px).empty()) return false;
  if (seen.size_m.x() * seen.size_m.y() > largest_share * object.size_m.x() * object.size_m.y())
    return false;
  const int common = (object.box_px & seen.box_px).area();
  if (common > kMostHidden * seen.box_px.area() && object.distance_m < seen.distance_m) return true;
  const double depth_gap_m = std::max(seen.distance_m - (object.distance_m + object.size_m.z()),
                                      object.distance_m - (seen.distance_m + seen.size_m.z()));
  if (depth_gap_m > kDepthGap_m) return false;
  if (!seen.has_velocity || !object.has_velocity) return true;
  const Eigen::Matrix3d covariance = seen.velocity_covariance + object.velocity_covariance +
                                     kSigma_mps * kSigma_mps * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d difference = seen.velocity_mps - object.velocity_mps;
  return difference.dot(covariance.inverse() * difference) < kMostSigmas * kMostSigmas;
}

}  // namespace predictive_stereo
