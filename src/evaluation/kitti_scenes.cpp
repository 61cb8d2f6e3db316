#include "evaluation/kitti_scenes.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "evaluation/disparity_metrics.h"
#include "evaluation/sequence.h"
#include "tools/kitti_drive.h"

namespace predictive_stereo {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> listScenes(const std::string& folder) {
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

// @param size  of the scene's first image; empty: this is the first one.
cv::Mat readPicture(const std::string& path, cv::Size size, int flags, int type,
                    const char* refusal) {
  const cv::Mat image = cv::imread(path, flags);
  if (image.empty() || image.type() != type) throw std::runtime_error(path + refusal);
  const auto text = [](cv::Size s) {
    return std::to_string(s.width) + "x" + std::to_string(s.height);
  };
  if (!size.empty() && image.size() != size)
    throw std::runtime_error(path + ": is " + text(image.size()) +
                             ", but the scene's first image is " + text(size) +
                             "; unpack the scene again");
  return image;
}

cv::Mat1b readGrey(const std::string& path, cv::Size size) {
  return readPicture(path, size, cv::IMREAD_GRAYSCALE, CV_8UC1, ": cannot be read as an image");
}

cv::Mat1f readTruth(const std::string& path, cv::Size size) {
  const cv::Mat coded = readPicture(path, size, cv::IMREAD_UNCHANGED, CV_16UC1,
                                    ": cannot be read as a 16-bit grey image");
  cv::Mat1f truth_px;
  coded.convertTo(truth_px, CV_32F, 1.0 / 256);
  truth_px.setTo(kNoTruth, coded == 0);
  return truth_px;
}

class KittiScene2012 : public Sequence {
 public:
  KittiScene2012(const std::string& training_dir, const std::string& scene)
      : dir_(training_dir), name_(scene) {
    if (!fs::is_directory(dir_)) throw std::runtime_error(dir_ + ": folder not found");
    const KittiCalibrationFile calibration(dir_ + "/calib/" + scene + ".txt");
    const auto hasPair = [&](int number) {
      return fs::is_regular_file(file("image_0", number)) &&
             fs::is_regular_file(file("image_1", number));
    };
    first_ = kTruthFile + 1;
    while (first_ > 0 && hasPair(first_ - 1)) --first_;
    if (frames() == 0)
      throw std::runtime_error(
          file("image_0", kTruthFile) +
          ": the file, or that in image_1, is missing; unpack the scene again");
    const cv::Size size = cv::imread(file("image_0", first_), cv::IMREAD_GRAYSCALE).size();
    rig_ = StereoRig::fromProjections(calibration.projection("P0"), calibration.projection("P1"),
                                      size);
  }
  const std::string& name() const override { return name_; }
  const StereoRig& rig() const override { return rig_; }
  int frames() const override { return kTruthFile - first_ + 1; }
  SequenceFrame frame(int index) const override {
    const int number = first_ + index;
    SequenceFrame frame{readGrey(file("image_0", number), rig_.size),
                        readGrey(file("image_1", number), rig_.size),
                        {},
                        {}};
    if (number == kTruthFile) {
      frame.truth_px = readTruth(file("disp_occ", number), rig_.size);
      frame.regions = {{"near edges", nearTruthEdges(frame.truth_px)}};
    }
    return frame;
  }
  std::optional<std::vector<ObjectLabel>> objects(int) const override {
    return std::vector<ObjectLabel>();
  }

 private:
  static constexpr int kTruthFile = 10;  // number of the pair with truth

  std::string file(const std::string& folder, int number) const {
    char suffix[16];
    std::snprintf(suffix, sizeof(suffix), "_%02d.png", number);
    return dir_ + "/" + folder + "/" + name_ + suffix;
  }

  std::string dir_, name_;
  StereoRig rig_;
  int first_;  // number of the first pair
};

}  // namespace

std::vector<std::string> listKittiScenes2012(const std::string& training_dir) {
  return listScenes(training_dir + "/disp_occ");
}

std::vector<std::string> listKittiScenes2015(const std::string& training_dir) {
  return listScenes(training_dir + "/disp_occ_0");
}

std::unique_ptr<Sequence> kittiScene2012Sequence(const std::string& training_dir,
                                                 const std::string& scene) {
  return std::make_unique<KittiScene2012>(training_dir, scene);
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
  if (fs::is_regular_file(file("disp_noc_0")))
    read.truth_noc_px = readTruth(file("disp_noc_0"), size);
  read.vehicles = readGrey(file("obj_map"), size) > 0;
  const KittiCalibrationFile calibration(training_dir + "/calib_cam_to_cam/" + scene + ".txt");
  read.rig = StereoRig::fromProjections(calibration.projection("P_rect_02"),
                                        calibration.projection("P_rect_03"), size);
  return read;
}

}  // namespace predictive_stereo
