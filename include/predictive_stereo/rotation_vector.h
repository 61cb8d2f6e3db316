#pragma once

#include <Eigen/Geometry>

namespace predictive_stereo {

/// The rotation about the vector's axis by its length [rad]; identity for the zero vector.
inline Eigen::Matrix3d rotationBy(const Eigen::Vector3d& w_rad) {
  const double angle_rad = w_rad.norm();
  if (angle_rad == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle_rad, w_rad / angle_rad).toRotationMatrix();
}

}  // namespace predictive_stereo
