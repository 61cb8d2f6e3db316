#pragma once

#include <Eigen/Geometry>
#include <map>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// A KITTI calibration file: lines "NAME: number number ...". Other lines (dates) are kept as names
/// without numbers.
class KittiCalibrationFile {
 public:
  /// @throws std::runtime_error if the file cannot be read.
  explicit KittiCalibrationFile(const std::string& path);

  /// @throws std::runtime_error with file and entry, if the entry is missing or does not have
  ///   `count` numbers.
  const std::vector<double>& numbers(const std::string& name, size_t count) const;
  Matrix34d projection(const std::string& name) const;
  Eigen::Matrix3d matrix3(const std::string& name) const;
  /// The rigid motion of the entries R and T; R is made orthonormal (files round it).
  Eigen::Isometry3d rigidMotion() const;

 private:
  std::string path_;
  std::map<std::string, std::vector<double>> entries_;
};

/// One camera of a KITTI raw recording, as calib_cam_to_cam.txt describes it.
struct KittiCamera {
  int number = 0;                 ///< 0, 1: grey left, right; 2, 3: colour left, right
  Eigen::Matrix3d K;              ///< of the unrectified camera
  Eigen::Matrix<double, 5, 1> D;  ///< of the unrectified camera: k1, k2, p1, p2, k3
  Eigen::Matrix3d R_rect;         ///< rotates unrectified into rectified camera coordinates
  Matrix34d P_rect;               ///< projects points of rectified camera 0
  /// Maps points of rectified camera 0 into this camera's rectified frame (a translation).
  Eigen::Isometry3d T_cam_cam0 = Eigen::Isometry3d::Identity();
};

/// @param calibration  calib_cam_to_cam.txt.
KittiCamera kittiCamera(const KittiCalibrationFile& calibration, int number);

}  // namespace predictive_stereo
