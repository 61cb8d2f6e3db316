#include "evaluation/kitti_scene_2012.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "evaluation/disparity_metrics.h"
#include "tools/kitti_calibration.h"

namespace predictive_stereo {
namespace {

namespace fs = std::filesystem;

std::string sceneFile(const std::string& dir, const std::string& folder, const std::string& scene,
                      int number) {
  char suffix[16];
  std::snprintf(suffix, sizeof(suffix), "_%02d.png", number);
  return dir + "/" + folder + "/" + scene + suffix;
}

}  // namespace

KittiScene2012::KittiScene2012(const std::string& training_dir, const std::string& scene)
    : dir_(training_dir), name_(scene) {
  if (!fs::is_directory(dir_)) throw std::runtime_error(dir_ + ": folder not found");
  const KittiCalibrationFile calibration(dir_ + "/calib/" + scene + ".txt");
  for (int number = kTruthFile;
       number >= 0 && fs::is_regular_file(sceneFile(dir_, "image_0", scene, number)) &&
       fs::is_regular_file(sceneFile(dir_, "image_1", scene, number));
       --number)
    ++frames_;
  if (frames_ == 0)
    throw std::runtime_error(sceneFile(dir_, "image_0", scene, kTruthFile) +
                             ": the file, or that in image_1, is missing; unpack the scene again");
  const cv::Size size = cv::imread(file("image_0", 0), cv::IMREAD_GRAYSCALE).size();
  rig_ =
      StereoRig::fromProjections(calibration.projection("P0"), calibration.projection("P1"), size);
}

std::vector<std::string> KittiScene2012::list(const std::string& training_dir) {
  const std::string folder = training_dir + "/disp_occ";
  if (!fs::is_directory(folder)) throw std::runtime_error(folder + ": folder not found");
  std::vector<std::string> scenes;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string file = entry.path().filename().string();
    if (file.size() == 13 && file.substr(6) == "_10.png") scenes.push_back(file.substr(0, 6));
  }
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

std::string KittiScene2012::file(const std::string& folder, int frame) const {
  return sceneFile(dir_, folder, name_, kTruthFile - frames_ + 1 + frame);
}

cv::Mat1b KittiScene2012::image(const std::string& folder, int frame) const {
  const std::string path = file(folder, frame);
  const cv::Mat1b image = cv::imread(path, cv::IMREAD_GRAYSCALE);
  if (image.empty()) throw std::runtime_error(path + ": cannot be read as an image");
  if (image.size() != rig_.size)
    throw std::runtime_error(path + ": is " + std::to_string(image.cols) + "x" +
                             std::to_string(image.rows) + ", but the scene's first image is " +
                             std::to_string(rig_.size.width) + "x" +
                             std::to_string(rig_.size.height) + "; unpack the scene again");
  return image;
}

cv::Mat1f KittiScene2012::truth(bool occluded) const {
  const std::string path = sceneFile(dir_, occluded ? "disp_occ" : "disp_noc", name_, kTruthFile);
  const cv::Mat coded = cv::imread(path, cv::IMREAD_UNCHANGED);
  if (coded.empty() || coded.type() != CV_16UC1)
    throw std::runtime_error(path + ": cannot be read as a 16-bit grey image");
  cv::Mat1f truth_px;
  coded.convertTo(truth_px, CV_32F, 1.0 / 256);
  truth_px.setTo(kNoTruth, coded == 0);
  return truth_px;
}

}  // namespace predictive_stereo
