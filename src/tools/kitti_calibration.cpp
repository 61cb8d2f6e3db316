#include "tools/kitti_calibration.h"

#include <Eigen/SVD>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace predictive_stereo {

KittiCalibrationFile::KittiCalibrationFile(const std::string& path) : path_(path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read (KITTI calibration file)");
  std::string line;
  while (std::getline(file, line)) {
    const size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    std::istringstream text(line.substr(colon + 1));
    std::vector<double> numbers;
    for (double number; text >> number;) numbers.push_back(number);
    entries_[line.substr(0, colon)] = numbers;
  }
}

const std::vector<double>& KittiCalibrationFile::numbers(const std::string& name,
                                                         size_t count) const {
  const auto entry = entries_.find(name);
  if (entry == entries_.end())
    throw std::runtime_error(path_ + ": has no entry " + name + "; unpack the file again");
  if (entry->second.size() != count)
    throw std::runtime_error(path_ + ": " + name + " has " + std::to_string(entry->second.size()) +
                             " numbers, expected " + std::to_string(count));
  return entry->second;
}

Matrix34d KittiCalibrationFile::projection(const std::string& name) const {
  return Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(numbers(name, 12).data());
}

Eigen::Matrix3d KittiCalibrationFile::matrix3(const std::string& name) const {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers(name, 9).data());
}

Eigen::Isometry3d KittiCalibrationFile::rigidMotion() const {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix3("R"),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = svd.matrixU() * svd.matrixV().transpose();
  motion.translation() = Eigen::Map<const Eigen::Vector3d>(numbers("T", 3).data());
  return motion;
}

KittiCamera kittiCamera(const KittiCalibrationFile& calibration, int number) {
  const std::string suffix = "_0" + std::to_string(number);
  KittiCamera camera;
  camera.number = number;
  camera.K = calibration.matrix3("K" + suffix);
  camera.D =
      Eigen::Map<const Eigen::Matrix<double, 5, 1>>(calibration.numbers("D" + suffix, 5).data());
  camera.R_rect = calibration.matrix3("R_rect" + suffix);
  camera.P_rect = calibration.projection("P_rect" + suffix);
  // P_rect = K_rect [I | t], t the position of camera 0 in this camera's frame.
  camera.T_cam_cam0.translation() = camera.P_rect.leftCols<3>().inverse() * camera.P_rect.col(3);
  return camera;
}

}  // namespace predictive_stereo
