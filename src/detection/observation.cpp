#include "detection/observation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "detection/constants.h"

namespace predictive_stereo {
namespace {

constexpr int kMostPoints = 1500;  // more do not improve the result

double quantile(std::vector<float>& values, double share) {
  const auto k =
      static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return static_cast<double>(values[static_cast<size_t>(k)]);
}

// Without thin lines at the ends.
cv::Range withoutEnds(const std::vector<int>& counts) {
  const double thin = kThinnestLine * *std::max_element(counts.begin(), counts.end());
  cv::Range kept(0, static_cast<int>(counts.size()));
  const auto at = [&](int i) { return counts[static_cast<size_t>(i)]; };
  while (!kept.empty() && at(kept.start) <= thin) ++kept.start;
  while (!kept.empty() && at(kept.end - 1) <= thin) --kept.end;
  return kept;
}

cv::Rect withoutEnds(const cv::Mat1b& mask) {
  std::vector<int> columns(static_cast<size_t>(mask.cols)), rows(static_cast<size_t>(mask.rows));
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (mask(y, x)) ++columns[static_cast<size_t>(x)], ++rows[static_cast<size_t>(y)];
  const cv::Range across = withoutEnds(columns), down = withoutEnds(rows);
  return {across.start, down.start, across.size(), down.size()};
}

bool haveSameVelocity(const Observation& one, const Observation& other) {
  const Eigen::Matrix3d covariance = one.velocity_covariance + other.velocity_covariance +
                                     kOwnMotion_mps * kOwnMotion_mps * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d difference = one.velocity_mps - other.velocity_mps;
  return difference.dot(covariance.inverse() * difference) <
         kMostSigmasOfVelocity * kMostSigmasOfVelocity;
}

// Whether most pixels between two boxes have this disparity, if they are side by side or one above
// the other.
bool isSurfaceBetween(const cv::Mat1f& disparity_px, const cv::Rect& a, const cv::Rect& b,
                      double expected_px) {
  const cv::Point first(std::max(a.x, b.x), std::max(a.y, b.y)),
      end(std::min(a.br().x, b.br().x), std::min(a.br().y, b.br().y));
  if (end.x >= first.x && end.y >= first.y) return true;
  if (end.x <= first.x && end.y <= first.y) return false;
  const cv::Mat1f between = disparity_px(cv::Rect(first, end));
  const double tolerance_px = kDisparityError_px + kSameSurface * expected_px;
  const int alike = cv::countNonZero(cv::abs(between - expected_px) <= tolerance_px);
  return 2 * alike >= static_cast<int>(between.total());
}

}  // namespace

bool measureShape(const DetectionInput& input, const DisparityRange& range, Observation& seen) {
  const cv::Rect& area = seen.box_px;
  CV_Assert(seen.mask.size() == area.size());
  const int step = std::max(1, static_cast<int>(std::sqrt(area.area() / double(kMostPoints))));
  std::array<std::vector<float>, 3> points;
  for (int y = 0; y < area.height; y += step)
    for (int x = 0; x < area.width; x += step) {
      const float d = input.measured_disparity_px(area.y + y, area.x + x);
      if (!seen.mask(y, x) || !range.isValid(d) || !(d > 0)) continue;
      const Eigen::Vector3d point = input.rig.pointFromDisparity(area.x + x, area.y + y, d);
      for (size_t k = 0; k < 3; ++k) points[k].push_back(static_cast<float>(point[int(k)]));
    }
  if (points[0].size() < kFewestPoints) return false;
  for (size_t k = 0; k < 3; ++k) {
    const double first = quantile(points[k], kTail), last = quantile(points[k], 1 - kTail);
    seen.centre_m[int(k)] = 0.5 * (first + last);
    seen.size_m[int(k)] = last - first;
    seen.distance_m = first;  // of the depth, which is the last one
  }
  return true;
}

Eigen::Matrix3d centreCovariance(const StereoRig& rig, double disparity_px) {
  const double depth_m = rig.disparityTimesDepth() / disparity_px;
  const double sigma_z_m = kDepthSigma_m + kDepthSigma_px * depth_m / disparity_px;
  const double across_m2 = kCentreSigma_m * kCentreSigma_m;
  return Eigen::Vector3d(across_m2, across_m2, sigma_z_m * sigma_z_m).asDiagonal();
}

Observation joined(const Observation& part, const Observation& whole) {
  const cv::Rect of_part = part.box_px, kept = withoutEnds(whole.mask);
  if (kept.empty()) return part;
  const cv::Rect of_whole = kept + whole.box_px.tl();
  Observation both = part;
  const cv::Rect box = of_part | of_whole;
  both.box_px = box;
  both.mask = cv::Mat1b(box.size(), uchar{0});  // not the memory of the part's
  whole.mask(kept).copyTo(both.mask(of_whole - box.tl()));
  both.mask(of_part - box.tl()).setTo(255, part.mask);
  return both;
}

LowerEnd lowerEndOf(const DepthCells& cells, const std::optional<GroundPlane>& ground,
                    const cv::Rect& box, float nearest_px) {
  const cv::Mat1f& disparity_px = cells.disparity_px;
  const auto cellsUntil = [](int end_px) { return (end_px + kCellSide_px - 1) / kCellSide_px; };
  const int below = cellsUntil(box.br().y);
  if (below >= disparity_px.rows) return LowerEnd::kCut;
  if (!ground) return LowerEnd::kFoot;
  const int left = box.x / kCellSide_px,
            right = std::min(cellsUntil(box.br().x), disparity_px.cols);
  int hidden = 0;  // columns
  for (int u = left; u < right; ++u) {
    const float d = disparity_px(below, u);
    hidden += d > nearest_px && ground->heightOf({u, below}, d) > kGap_m;
  }
  return 2 * hidden > right - left ? LowerEnd::kHidden : LowerEnd::kFoot;
}

bool isPlausible(const MotionDetectionParams& params, const Extent& extent, LowerEnd lower_end) {
  const double visible = lower_end == LowerEnd::kFoot     ? 1
                         : lower_end == LowerEnd::kHidden ? kLeastVisible
                                                          : 0;
  if (extent.width_m < params.min_width_m || extent.width_m > params.max_width_m ||
      extent.height_m < visible * params.min_height_m || extent.height_m > params.max_height_m)
    return false;
  if (lower_end == LowerEnd::kCut || !extent.above_ground) return true;
  const auto [foot_m, top_m] = *extent.above_ground;
  return top_m <= params.max_height_m &&
         (lower_end == LowerEnd::kHidden || foot_m <= params.max_foot_m);
}

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

bool belongsTo(const MotionDetectionParams& params, const Observation& seen,
               const Observation& object) {
  const int gap_px = static_cast<int>(kGap_m / object.size_m.x() * object.box_px.width);
  const cv::Rect around(object.box_px.x - gap_px, object.box_px.y - gap_px,
                        object.box_px.width + 2 * gap_px, object.box_px.height + 2 * gap_px);
  if ((around & seen.box_px).empty()) return false;
  if (seen.size_m.x() * seen.size_m.y() > kLargestSide * object.size_m.x() * object.size_m.y())
    return false;
  const double depth_gap_m = std::max(seen.distance_m - (object.distance_m + object.size_m.z()),
                                      object.distance_m - (seen.distance_m + seen.size_m.z()));
  return depth_gap_m <= params.max_width_m / 2 && haveSameVelocity(seen, object);
}

bool moveAsOne(const DetectionInput& input, const MotionDetectionParams& params,
               const Observation& one, const Observation& other) {
  const double disparity_times_depth = input.rig.disparityTimesDepth();
  const double d_one = disparity_times_depth / one.centre_m.z(),
               d_other = disparity_times_depth / other.centre_m.z();
  const bool same_depth =
      std::abs(one.centre_m.z() - other.centre_m.z()) <= params.layer_margin_m ||
      std::abs(d_one - d_other) <= kDisparityError_px;
  const bool cover_most =
      one.box_px.area() + other.box_px.area() >= kLeastCovered * (one.box_px | other.box_px).area();
  return same_depth && cover_most && haveSameVelocity(one, other) &&
         isSurfaceBetween(input.measured_disparity_px, one.box_px, other.box_px,
                          0.5 * (d_one + d_other));
}

}  // namespace predictive_stereo
