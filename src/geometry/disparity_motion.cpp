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

}  // namespace predictive_stereo
