#include "predictive_stereo/disparity_motion.h"

#include <Eigen/LU>

namespace predictive_stereo {
namespace {

// Takes (x, y, d, 1) to a multiple of (X, Y, Z, 1).
Eigen::Matrix4d euclideanFromDisparity(const StereoRig& rig) {
  Eigen::Matrix4d M;
  M << 1 / rig.fx_px, 0, 0, -rig.cx_left_px / rig.fx_px,  //
      0, 1 / rig.fy_px, 0, -rig.cy_px / rig.fy_px,        //
      0, 0, 0, 1,                                         //
      0, 0, 1 / rig.disparityTimesDepth(), 0;
  return M;
}

}  // namespace

Eigen::Matrix4d disparityMotion(const StereoRig& rig, const Eigen::Isometry3d& T_cam_prev) {
  const Eigen::Matrix4d M = euclideanFromDisparity(rig);
  return M.inverse() * T_cam_prev.matrix() * M;
}

Vector6d disparityJacobian(const StereoRig& rig, double x_px, double y_px, double disparity_px) {
  // d = fB / Z, and the perturbation changes Z by t_z + (r x X)_z = t_z + r_x Y - r_y X.
  const Eigen::Vector3d point_m = rig.pointFromDisparity(x_px, y_px, disparity_px);
  const double d_by_depth = -disparity_px / point_m.z();
  Vector6d jacobian;
  jacobian << 0, 0, d_by_depth, d_by_depth * point_m.y(), -d_by_depth * point_m.x(), 0;
  return jacobian;
}

}  // namespace predictive_stereo
