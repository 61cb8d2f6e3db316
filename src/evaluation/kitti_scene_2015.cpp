#include "evaluation/kitti_scene_2015.h"

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "evaluation/disparity_metrics.h"
#include "tools/kitti_calibration.h"

namespace predictive_stereo {
namespace {

namespace fs = std::filesystem;

void requireSize(const std::string& path, cv::Size size, cv::Size left) {
  if (size == left) return;
  const auto text = [](cv::Size s) {
    return std::to_string(s.width) + "x" + std::to_string(s.height);
  };
  throw std::runtime_error(path + ": is " + text(size) + ", but the scene's left image is " +
                           text(left) + "; unpack the scene again");
}

cv::Mat1b readGrey(const std::string& path, cv::Size size) {
  const cv::Mat1b image = cv::imread(path, cv::IMREAD_GRAYSCALE);
  if (image.empty()) throw std::runtime_error(path + ": cannot be read as an image");
  if (!size.empty()) requireSize(path, image.size(), size);
  return image;
}

cv::Mat1f readTruth(const std::string& path, cv::Size size) {
  const cv::Mat coded = cv::imread(path, cv::IMREAD_UNCHANGED);
  if (coded.empty() || coded.type() != CV_16UC1)
    throw std::runtime_error(path + ": cannot be read as a 16-bit grey image");
  requireSize(path, coded.size(), size);
  cv::Mat1f truth_px;
  coded.convertTo(truth_px, CV_32F, 1.0 / 256);
  truth_px.setTo(kNoTruth, coded == 0);
  return truth_px;
}

}  // namespace

std::vector<std::string> listKittiScenes2015(const std::string& training_dir) {
  const std::string folder = training_dir + "/disp_occ_0";
  if (!fs::is_directory(folder)) throw std::runtime_error(folder + ": folder not found");
  std::vector<std::string> scenes;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string file = entry.path().filename().string();
    if (file.size() == 13 && file.substr(6) == "_10.png") scenes.push_back(file.substr(0, 6));
  }
  if (scenes.empty())
    throw std::runtime_error(folder + ": has no files NNNNNN_10.png; give the training folder");
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

KittiScene2015 readKittiScene2015(const std::string& training_dir, const std::string& scene) {
  const auto file = [&](const char* folder) {
    return training_dir + "/" + folder + "/" + scene + "_10.png";
  };
  KittiScene2015 read;
  read.name = scene;
  read.left = readGrey(file("image_2"), {});
  const cv::Size size = read.left.size();
  read.right = readGrey(file("image_3"), size);
  read.truth_px = readTruth(file("disp_occ_0"), size);
  if (fs::is_regular_file(file("disp_noc_0"))) {
    read.truth_noc_px = readTruth(file("disp_noc_0"), size);
  }
  read.vehicles = readGrey(file("obj_map"), size) > 0;
  const KittiCalibrationFile calibration(training_dir + "/calib_cam_to_cam/" + scene + ".txt");
  read.rig = StereoRig::fromProjections(calibration.projection("P_rect_02"),
                                        calibration.projection("P_rect_03"), size);
  return read;
}

}  // namespace predictive_stereo
