#include "tools/kitti_drive.h"

#include <Eigen/SVD>
#include <boost/algorithm/string/trim.hpp>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>

namespace predictive_stereo {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& file, const std::string& reason) {
  throw std::runtime_error(file + ": " + reason);
}

constexpr int kLargestFile = 1000000000;

/// Numbers of the files <number>.<extension> in a folder.
std::set<int> fileNumbers(const std::string& folder, const std::string& extension) {
  if (!fs::is_directory(folder)) fail(folder, "folder not found");
  std::set<int> numbers;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string stem = entry.path().stem().string();
    if (entry.path().extension() != extension || stem.size() != 10 ||
        stem.find_first_not_of("0123456789") != std::string::npos)
      continue;
    const long long number = std::stoll(stem);
    if (number > kLargestFile) fail(entry.path().string(), "its number is too large");
    numbers.insert(static_cast<int>(number));
  }
  if (numbers.empty()) fail(folder, "has no images (0000000000" + extension + ", ...)");
  return numbers;
}

/// "2011-09-26 13:08:24.973999360" to nanoseconds; none if it is malformed, or if ROS's 32 bits for
/// the seconds (1970 to 2106) cannot hold it.
std::optional<int64_t> parseTimestamp(const std::string& line) {
  static const std::regex form(R"((\d{4}-\d\d-\d\d \d\d:\d\d:\d\d)(?:\.(\d{1,9}))?)");
  std::smatch parts;
  if (!std::regex_match(line, parts, form)) return std::nullopt;
  std::tm time{};
  std::istringstream text(parts[1].str());
  text >> std::get_time(&time, "%Y-%m-%d %H:%M:%S");
  if (!text) return std::nullopt;
  const int64_t seconds = timegm(&time);
  if (seconds < 0 || seconds > std::numeric_limits<uint32_t>::max()) return std::nullopt;
  std::string fraction = parts[2].str();
  fraction.resize(9, '0');
  return seconds * 1000000000 + std::stoll(fraction);
}

std::vector<Eigen::Isometry3d> readPoses(const std::string& path) {
  std::ifstream file(path);
  if (!file) fail(path, "cannot be read");
  std::vector<Eigen::Isometry3d> poses;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (boost::algorithm::trim_copy(line).empty()) continue;
    std::istringstream text(line);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 12; ++i)
      if (!(text >> pose.matrix()(i / 4, i % 4)))
        fail(path, "line " + std::to_string(number) +
                       " must have the 12 numbers of a 3x4 pose; unpack the file again");
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace

KittiCalibrationFile::KittiCalibrationFile(const std::string& path) : path_(path) {
  std::ifstream file(path);
  if (!file) fail(path, "cannot be read (KITTI calibration file)");
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
  if (entry == entries_.end()) fail(path_, "has no entry " + name + "; unpack the file again");
  if (entry->second.size() != count)
    fail(path_, name + " has " + std::to_string(entry->second.size()) + " numbers, expected " +
                    std::to_string(count));
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

cv::Mat readPicture(const std::string& path, int type, cv::Size size) {
  const bool grey = type == CV_8UC1, coded = type == CV_16UC1;
  const int flags = grey ? cv::IMREAD_GRAYSCALE : coded ? cv::IMREAD_UNCHANGED : cv::IMREAD_COLOR;
  const cv::Mat picture = cv::imread(path, flags);
  const bool readable = !picture.empty() && picture.type() == type;
  if (!readable && coded) fail(path, "cannot be read as a 16-bit grey image");
  if (!readable) fail(path, "cannot be read as an image");
  if (!size.empty() && picture.size() != size)
    fail(path, cv::format("is %dx%d, but the recording's first image is %dx%d; unpack it again",
                          picture.cols, picture.rows, size.width, size.height));
  return picture;
}

Eigen::Quaterniond OxtsRecord::attitude() const {
  const double roll_rad = fields[3], pitch_rad = fields[4], yaw_rad = fields[5];
  return Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX());
}

std::vector<Eigen::Isometry3d> posesFromOxts(const std::vector<OxtsRecord>& records) {
  constexpr double kEarthRadius_m = 6378137.0;
  constexpr double kRadians = M_PI / 180.0;
  std::vector<Eigen::Isometry3d> poses;
  if (records.empty()) return poses;
  const double scale = std::cos(records.front().latitude_deg() * kRadians) * kEarthRadius_m;
  const auto position = [scale](const OxtsRecord& record) {
    return Eigen::Vector3d(
        scale * record.longitude_deg() * kRadians,
        scale * std::log(std::tan((90.0 + record.latitude_deg()) * kRadians / 2)),
        record.altitude_m());
  };
  const Eigen::Vector3d origin = position(records.front());
  for (const OxtsRecord& record : records) {
    Eigen::Isometry3d T_world_imu = Eigen::Isometry3d::Identity();
    T_world_imu.linear() = record.attitude().toRotationMatrix();
    T_world_imu.translation() = position(record) - origin;
    poses.push_back(T_world_imu);
  }
  return poses;
}

std::vector<int64_t> readKittiTimestamps(const std::string& path, size_t max_count) {
  std::ifstream file(path);
  if (!file) fail(path, "cannot be read");
  std::vector<int64_t> stamps;
  std::string line;
  for (int number = 1; stamps.size() < max_count && std::getline(file, line); ++number) {
    boost::algorithm::trim(line);
    if (line.empty()) continue;
    const auto stamp = parseTimestamp(line);
    if (!stamp)
      fail(path, "line " + std::to_string(number) + " \"" + line +
                     "\" is not a time stamp such as 2011-09-26 13:08:24.973999360");
    stamps.push_back(*stamp);
  }
  return stamps;
}

KittiDrive::KittiDrive(const std::string& date_dir, const std::string& drive, int left_camera)
    : date_dir_(date_dir), name_(drive), dir_((fs::path(date_dir) / drive).string()) {
  if (!fs::is_directory(date_dir)) fail(date_dir, "folder not found");
  if (!fs::is_directory(dir_)) fail(dir_, "folder not found");
  const KittiCalibrationFile calibration((fs::path(date_dir) / "calib_cam_to_cam.txt").string());
  left_ = kittiCamera(calibration, left_camera);
  right_ = kittiCamera(calibration, left_camera + 1);

  const auto left_files = fileNumbers(dir_ + "/" + imageFolder(left_) + "/data", ".png");
  const auto right_files = fileNumbers(dir_ + "/" + imageFolder(right_) + "/data", ".png");
  first_file_ = std::max(*left_files.begin(), *right_files.begin());
  const int last_file = std::min(*left_files.rbegin(), *right_files.rbegin());
  frames_ = std::max(0, last_file - first_file_ + 1);
  if (frames_ == 0)
    fail(dir_, "left and right images have no frame in common; unpack the drive again");
  for (int frame = 0; frame < frames_; ++frame) {
    if (!left_files.count(fileNumber(frame)))
      fail(dataFile(imageFolder(left_), frame, "png"), "is missing, though later images exist");
    if (!right_files.count(fileNumber(frame)))
      fail(dataFile(imageFolder(right_), frame, "png"), "is missing, though later images exist");
  }
  const cv::Mat first = readPicture(dataFile(imageFolder(left_), 0, "png"), CV_8UC1, {});
  rig_ = StereoRig::fromProjections(left_.P_rect, right_.P_rect, first.size());
}

std::string KittiDrive::dataFile(const std::string& folder, int frame,
                                 const std::string& extension) const {
  return dir_ + "/" + folder + "/data/" + cv::format("%010d.", fileNumber(frame)) + extension;
}

std::string KittiDrive::imageFolder(const KittiCamera& camera) {
  return "image_0" + std::to_string(camera.number);
}

cv::Mat KittiDrive::image(const KittiCamera& camera, int frame) const {
  return readPicture(dataFile(imageFolder(camera), frame, "png"),
                     camera.number < 2 ? CV_8UC1 : CV_8UC3, rig_.size);
}

cv::Mat1b KittiDrive::grayImage(const KittiCamera& camera, int frame) const {
  cv::Mat gray = image(camera, frame);
  if (gray.channels() == 3) cv::cvtColor(gray, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

std::vector<int64_t> KittiDrive::stamps(const std::string& folder) const {
  const std::string path = dir_ + "/" + folder + "/timestamps.txt";
  const size_t needed = static_cast<size_t>(first_file_ + frames_);
  std::vector<int64_t> stamps = readKittiTimestamps(path, needed);
  if (stamps.size() < needed)
    fail(path, "has " + std::to_string(stamps.size()) + " time stamps, but the images go up to " +
                   std::to_string(needed - 1));
  stamps.erase(stamps.begin(), stamps.begin() + first_file_);
  return stamps;
}

bool KittiDrive::hasLidar(int frame) const {
  return fs::is_regular_file(dataFile("velodyne_points", frame, "bin"));
}

std::vector<LidarPoint> KittiDrive::lidar(int frame) const {
  const std::string path = dataFile("velodyne_points", frame, "bin");
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) fail(path, "cannot be read");
  const auto bytes = static_cast<size_t>(file.tellg());
  if (bytes == 0 || bytes % sizeof(LidarPoint) != 0)
    fail(path, "has " + std::to_string(bytes) +
                   " bytes, which is not a multiple of 16 (one point); unpack the scan again");
  std::vector<LidarPoint> points(bytes / sizeof(LidarPoint));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(points.data()), static_cast<std::streamsize>(bytes));
  if (!file) fail(path, "cannot be read to its end; unpack the scan again");
  return points;
}

Eigen::Isometry3d KittiDrive::T_cam_velo() const {
  const fs::path folder(date_dir_);
  const KittiCalibrationFile velo_to_cam((folder / "calib_velo_to_cam.txt").string());
  const KittiCalibrationFile cam_to_cam((folder / "calib_cam_to_cam.txt").string());
  Eigen::Isometry3d R_rect = Eigen::Isometry3d::Identity();
  R_rect.linear() = cam_to_cam.matrix3("R_rect_00");
  return left_.T_cam_cam0 * R_rect * velo_to_cam.rigidMotion();
}

Eigen::Isometry3d KittiDrive::T_velo_imu() const {
  return KittiCalibrationFile((fs::path(date_dir_) / "calib_imu_to_velo.txt").string())
      .rigidMotion();
}

bool KittiDrive::hasOxts() const { return fs::is_regular_file(dataFile("oxts", 0, "txt")); }

OxtsRecord KittiDrive::oxts(int frame) const {
  const std::string path = dataFile("oxts", frame, "txt");
  std::ifstream file(path);
  if (!file) fail(path, "cannot be read");
  OxtsRecord record;
  for (size_t i = 0; i < record.fields.size(); ++i)
    if (!(file >> record.fields[i]))
      fail(path, "has " + std::to_string(i) + " numbers, expected 30; unpack the file again");
  return record;
}

std::optional<std::vector<Eigen::Isometry3d>> KittiDrive::poses() const {
  std::vector<Eigen::Isometry3d> poses;
  const std::string truth = dir_ + "/poses_gt_cam0.txt";
  if (fs::is_regular_file(truth)) {
    poses = readPoses(truth);
    if (poses.size() < static_cast<size_t>(frames_))
      fail(truth, "has " + std::to_string(poses.size()) + " poses for " + std::to_string(frames_) +
                      " images");
    poses.resize(static_cast<size_t>(frames_));
    for (auto& pose : poses) pose = pose * left_.T_cam_cam0.inverse();
    return poses;
  }
  if (!hasOxts()) return std::nullopt;
  std::vector<OxtsRecord> records;
  for (int frame = 0; frame < frames_; ++frame) records.push_back(oxts(frame));
  poses = posesFromOxts(records);
  const Eigen::Isometry3d T_imu_cam = (T_cam_velo() * T_velo_imu()).inverse();
  for (auto& pose : poses) pose = pose * T_imu_cam;
  return poses;
}

}  // namespace predictive_stereo
