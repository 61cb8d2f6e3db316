#include "predictive_stereo/stereo_rig.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace predictive_stereo {
namespace {

// No image lies farther from its principal point.
constexpr double kFarthestPrincipalPoint_px = 1e6;
// RowAlignment corrects small ones.
constexpr double kLargestRowDifference_px = 3;

}  // namespace

StereoRig StereoRig::fromProjections(const Matrix34d& P_left, const Matrix34d& P_right,
                                     cv::Size size) {
  const auto refuse = [&](const std::string& reason) {
    std::ostringstream text;
    text << "stereo calibration cannot be used: " << reason << "\nP_left =\n"
         << P_left << "\nP_right =\n"
         << P_right;
    throw std::invalid_argument(text.str());
  };
  if (size.width <= 0 || size.height <= 0)
    refuse("image size is " + std::to_string(size.width) + "x" + std::to_string(size.height) +
           "; is the camera calibrated?");
  if (!P_left.allFinite() || !P_right.allFinite())
    refuse("a projection matrix has entries that are not finite; calibrate the cameras again");
  StereoRig rig;
  rig.size = size;
  rig.fx_px = P_left(0, 0);
  rig.fy_px = P_left(1, 1);
  rig.cx_left_px = P_left(0, 2);
  rig.cx_right_px = P_right(0, 2);
  rig.cy_px = P_left(1, 2);
  if (!(rig.fx_px > 0) || !(rig.fy_px > 0))
    refuse("focal length " + std::to_string(rig.fx_px) + " x " + std::to_string(rig.fy_px) +
           " px is not positive; is the camera calibrated?");
  if (std::abs(P_right(0, 0) - rig.fx_px) > 1e-3 * rig.fx_px ||
      std::abs(P_right(1, 1) - rig.fy_px) > 1e-3 * rig.fy_px)
    refuse("focal lengths of left (" + std::to_string(rig.fx_px) + " x " +
           std::to_string(rig.fy_px) + " px) and right camera (" + std::to_string(P_right(0, 0)) +
           " x " + std::to_string(P_right(1, 1)) +
           " px) differ; calibrate both cameras together, as a pair");
  for (const double c_px : {rig.cx_left_px, rig.cx_right_px, rig.cy_px})
    if (std::abs(c_px) > kFarthestPrincipalPoint_px) {
      std::ostringstream coordinate;
      coordinate << c_px;
      refuse("principal point: " + coordinate.str() +
             " px is too far from the image; calibrate the cameras again");
    }
  if (std::abs(P_right(1, 2) - rig.cy_px) > kLargestRowDifference_px)
    refuse("principal points are in row " + std::to_string(rig.cy_px) + " (left) and row " +
           std::to_string(P_right(1, 2)) +
           " (right), so equal rows do not see the same; rectify both cameras together, with the "
           "same roi.y_offset");
  rig.baseline_m = (P_left(0, 3) - P_right(0, 3)) / rig.fx_px;
  if (!(rig.baseline_m > 0))
    refuse("baseline " + std::to_string(rig.baseline_m) +
           " m is not positive; are left and right swapped, or is the pair not calibrated?");
  if (!std::isfinite(rig.baseline_m) || !std::isfinite(rig.disparityTimesDepth()))
    refuse("focal length " + std::to_string(rig.fx_px) + " px times baseline " +
           std::to_string(rig.baseline_m) + " m is not finite; calibrate the cameras again");
  return rig;
}

Eigen::Vector3d StereoRig::pointFromDisparity(double x_px, double y_px, double disparity_px) const {
  const double depth_m = disparityTimesDepth() / disparity_px;
  return {(x_px - cx_left_px) / fx_px * depth_m, (y_px - cy_px) / fy_px * depth_m, depth_m};
}

Eigen::Vector3d StereoRig::disparityFromPoint(const Eigen::Vector3d& point_cam_m) const {
  return {fx_px * point_cam_m.x() / point_cam_m.z() + cx_left_px,
          fy_px * point_cam_m.y() / point_cam_m.z() + cy_px,
          disparityTimesDepth() / point_cam_m.z()};
}

bool StereoRig::operator==(const StereoRig& other) const {
  return size == other.size && fx_px == other.fx_px && fy_px == other.fy_px &&
         cx_left_px == other.cx_left_px && cx_right_px == other.cx_right_px &&
         cy_px == other.cy_px && baseline_m == other.baseline_m;
}

}  // namespace predictive_stereo
