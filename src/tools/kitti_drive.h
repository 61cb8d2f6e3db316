#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
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

/// A picture as KITTI has it.
/// @param type  CV_8UC1, CV_8UC3 (BGR), CV_16UC1.
/// @param size  of the first one of the recording; empty: this is that one.
/// @throws std::runtime_error with the file, for what is not such a picture.
cv::Mat readPicture(const std::string& path, int type, cv::Size size);

/// One point of a laser scan, in the scanner's frame (x forward, y left, z up) [m].
struct LidarPoint {
  float x, y, z, reflectance;
};

/// One record of the inertial unit: the 30 fields of KITTI's oxts/dataformat.txt in their order.
struct OxtsRecord {
  std::array<double, 30> fields;

  double latitude_deg() const { return fields[0]; }
  double longitude_deg() const { return fields[1]; }
  double altitude_m() const { return fields[2]; }
  /// Rotation from the unit's axes to east, north, up.
  Eigen::Quaterniond attitude() const;
};

/// Positions and attitudes of the inertial unit: T_world_imu with axes east, north, up and the
/// first record's position as origin. Mercator projection at the first record's latitude, as
/// KITTI's devkit defines it (y = a s ln tan(45 deg + latitude / 2), s = cos of the first
/// latitude).
std::vector<Eigen::Isometry3d> posesFromOxts(const std::vector<OxtsRecord>& records);

/// Lines of a KITTI timestamps.txt, "2011-09-26 13:08:24.973999360", taken as UTC, in nanoseconds
/// since 1970. Blank lines are skipped. Reads at most `max_count` stamps: lines behind those of the
/// images need not be valid.
/// @throws std::runtime_error with file, line number and text of a malformed line, or if the file
///   cannot be read.
std::vector<int64_t> readKittiTimestamps(const std::string& path, size_t max_count);

/// A rectified ("sync") drive of the KITTI raw recordings. Frames are counted from 0 over the
/// images that exist for both cameras; there may be more timestamps and oxts records.
///
/// Every failure is a std::runtime_error with the name of the file.
class KittiDrive {
 public:
  /// @param date_dir  folder of a day, with calib_cam_to_cam.txt.
  /// @param drive  name of a drive's folder in it.
  /// @param left_camera  0: the grey pair; 2: the colour pair.
  KittiDrive(const std::string& date_dir, const std::string& drive, int left_camera = 0);

  const std::string& name() const { return name_; }
  const StereoRig& rig() const { return rig_; }
  const KittiCamera& leftCamera() const { return left_; }
  const KittiCamera& rightCamera() const { return right_; }
  int frames() const { return frames_; }
  /// Number of the frame's files, which labels refer to. It differs from the frame if the drive's
  /// first images are missing.
  int fileNumber(int frame) const { return first_file_ + frame; }

  /// Path of a frame's file, e.g. dataFile("image_00", 3, "png").
  std::string dataFile(const std::string& folder, int frame, const std::string& extension) const;

  /// 8-bit grey images (the colour pair's are converted).
  cv::Mat1b left(int frame) const { return grayImage(left_, frame); }
  cv::Mat1b right(int frame) const { return grayImage(right_, frame); }
  /// The image of leftCamera() or rightCamera() as recorded: 8-bit grey, or BGR.
  cv::Mat image(const KittiCamera& camera, int frame) const;

  /// Folder of a camera's images, "image_00" to "image_03".
  static std::string imageFolder(const KittiCamera& camera);

  /// Stamps of the frames' files in a folder, e.g. "image_00", "oxts", "velodyne_points".
  std::vector<int64_t> stamps(const std::string& folder) const;

  /// Whether the frame has a laser scan (a few are missing in KITTI's drives).
  bool hasLidar(int frame) const;
  std::vector<LidarPoint> lidar(int frame) const;
  /// Maps the scanner's points into the left camera's rectified frame.
  Eigen::Isometry3d T_cam_velo() const;
  /// Maps the inertial unit's frame to the scanner's.
  Eigen::Isometry3d T_velo_imu() const;

  bool hasOxts() const;
  OxtsRecord oxts(int frame) const;
  /// Poses T_world_cam of the left camera's optical frame: from poses_gt_cam0.txt if the drive has
  /// it, else from oxts (with axes east, north, up). None without both.
  std::optional<std::vector<Eigen::Isometry3d>> poses() const;

 private:
  cv::Mat1b grayImage(const KittiCamera& camera, int frame) const;

  std::string date_dir_;
  std::string name_;
  std::string dir_;
  KittiCamera left_, right_;
  StereoRig rig_;
  int first_file_ = 0;
  int frames_ = 0;
};

}  // namespace predictive_stereo
