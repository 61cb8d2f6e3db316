#include "detection/object_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace predictive_stereo {
namespace {

constexpr size_t kFewestPoints = 8;
constexpr int kMostPoints = 1500;  // more do not improve the result
constexpr double kTail = 0.05;     // share of points left out at both ends: false matches, edges

struct Extent {
  double first, last;
};

Extent extentOf(std::vector<float>& values) {
  const auto quantile = [&](double share) {
    const auto k =
        static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(values.size() - 1)));
    std::nth_element(values.begin(), values.begin() + k, values.end());
    return static_cast<double>(values[static_cast<size_t>(k)]);
  };
  const double first = quantile(kTail);
  return {first, quantile(1 - kTail)};
}

}  // namespace

std::optional<ObjectShape> shapeOf(const StereoRig& rig, const DisparityRange& range,
                                   const cv::Mat1f& disparity_px, const cv::Rect& area,
                                   const cv::Mat1b& mask) {
  CV_Assert(mask.size() == area.size());
  const int step = std::max(1, static_cast<int>(std::sqrt(area.area() / double(kMostPoints))));
  std::array<std::vector<float>, 3> points;
  for (int y = 0; y < area.height; y += step)
    for (int x = 0; x < area.width; x += step) {
      const float d = disparity_px(area.y + y, area.x + x);
      if (!mask(y, x) || !range.isValid(d) || !(d > 0)) continue;
      const Eigen::Vector3d point = rig.pointFromDisparity(area.x + x, area.y + y, d);
      for (size_t k = 0; k < 3; ++k) points[k].push_back(static_cast<float>(point[int(k)]));
    }
  if (points[0].size() < kFewestPoints) return std::nullopt;
  ObjectShape shape;
  for (size_t k = 0; k < 3; ++k) {
    const Extent extent = extentOf(points[k]);
    shape.centre_m[int(k)] = 0.5 * (extent.first + extent.last);
    shape.size_m[int(k)] = extent.last - extent.first;
    if (k == 2) shape.distance_m = extent.first;
  }
  return shape;
}

bool measureShape(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px,
                  ObservedObject& object) {
  Observation& seen = object.observation;
  const auto shape = shapeOf(rig, range, disparity_px, seen.box_px, object.mask);
  if (!shape) return false;
  seen.centre_m = shape->centre_m;
  seen.size_m = shape->size_m;
  seen.distance_m = shape->distance_m;
  return true;
}

Eigen::Matrix3d centreCovariance(const StereoRig& rig, double disparity_px) {
  const double depth_m = rig.disparityTimesDepth() / disparity_px;
  const double sigma_z_m = 0.3 + 0.3 * depth_m / disparity_px;
  return Eigen::Vector3d(0.04, 0.04, sigma_z_m * sigma_z_m).asDiagonal();
}

}  // namespace predictive_stereo
