#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

namespace predictive_stereo {

/// A folder that is removed with its contents at the end of a test.
class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::string pattern = (std::filesystem::temp_directory_path() / "predictive_stereo_XXXXXX");
    path_ = mkdtemp(pattern.data());
  }
  ~TemporaryDirectory() { std::filesystem::remove_all(path_); }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  std::string path(const std::string& name = "") const {
    return name.empty() ? path_ : path_ + "/" + name;
  }
  /// Writes a file, and makes its folders.
  std::string write(const std::string& name, const std::string& text) const {
    const std::filesystem::path file = path(name);
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file.string();
  }

 private:
  std::string path_;
};

/// A small drive in the layout of KITTI's raw recordings: focal length 100 px, baseline 0.5 m; the
/// grey pair is at camera 0, the colour pair is shifted by 0.06 m; the axes of scanner and cameras
/// differ by right angles.
class KittiFixture : public TemporaryDirectory {
 public:
  static constexpr const char* kDrive = "2011_09_26_drive_0001_sync";

  explicit KittiFixture(int frames = 3, cv::Size size = {64, 32}) : frames_(frames) {
    write("calib_cam_to_cam.txt", calibration(size));
    write("calib_velo_to_cam.txt",
          "calib_time: 25-May-2012 16:47:16\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.1 -0.3\n");
    write("calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n");
    for (const char* folder :
         {"image_00", "image_01", "image_02", "image_03", "oxts", "velodyne_points"}) {
      std::string stamps;
      for (int i = 0; i < frames + 2; ++i)  // more stamps than images, as in excerpts of KITTI
        stamps += "2011-09-26 13:08:2" + std::to_string(i) + ".500000001\n";
      write(data(folder) + "/timestamps.txt", stamps);
    }
    for (int i = 0; i < frames; ++i)
      for (int camera = 0; camera < 4; ++camera) {
        const cv::Mat image(size, camera >= 2 ? CV_8UC3 : CV_8UC1,
                            cv::Scalar::all(10 * i + camera));
        const std::string folder = "image_0" + std::to_string(camera);
        std::filesystem::create_directories(path(data(folder + "/data")));
        cv::imwrite(file(folder, i, "png"), image);
      }
  }

  /// Path of a file of the drive, relative to the fixture.
  static std::string data(const std::string& name) { return std::string(kDrive) + "/" + name; }
  std::string file(const std::string& folder, int number, const std::string& extension) const {
    char text[32];
    std::snprintf(text, sizeof(text), "%010d.", number);
    return path(data(folder + "/data/" + text + extension));
  }
  int frames() const { return frames_; }

 private:
  static std::string calibration(cv::Size size) {
    std::string text = "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.95e-02\n";
    const char* offsets[] = {"0", "-50", "6", "-44"};
    for (int camera = 0; camera < 4; ++camera) {
      const std::string n = "_0" + std::to_string(camera) + ": ";
      text += "S" + n + "80 40\nK" + n + "110 0 40 0 110 20 0 0 1\nD" + n +
              "-0.3 0.2 0.001 0.002 -0.07\nR" + n + "1 0 0 0 1 0 0 0 1\nT" + n + "0 0 0\nS_rect" +
              n + std::to_string(size.width) + " " + std::to_string(size.height) + "\nR_rect" + n +
              "1 0 0 0 1 0 0 0 1\nP_rect" + n + "100 0 32 " + offsets[camera] +
              " 0 100 16 0 0 0 1 0\n";
    }
    return text;
  }

  int frames_;
};

/// A scan's bytes: x, y, z, reflectance of each point.
inline std::string scanBytes(const std::vector<float>& numbers) {
  return std::string(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(float));
}

/// An oxts record at 49 degrees north; the fields from the sixth on are their numbers.
inline std::string oxtsText(double yaw_rad, double longitude_deg) {
  std::string text = "49 " + std::to_string(longitude_deg) + " 100 0 0 " + std::to_string(yaw_rad);
  for (int i = 6; i < 30; ++i) text += " " + std::to_string(i);
  return text;
}

/// Message of the exception that `action` throws.
template <class Action>
std::string messageOf(Action&& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing was thrown";
}

}  // namespace predictive_stereo
