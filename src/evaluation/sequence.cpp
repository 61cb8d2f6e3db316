#include "evaluation/sequence.h"

#include <filesystem>
#include <stdexcept>

#include "evaluation/disparity_metrics.h"
#include "evaluation/lidar_truth.h"
#include "predictive_stereo/rigid_motion.h"
#include "tools/kitti_drive.h"

namespace predictive_stereo {
namespace {

namespace fs = std::filesystem;

class KittiDriveSequence : public Sequence {
 public:
  KittiDriveSequence(const std::string& date_dir, const std::string& drive)
      : Sequence(drive), drive_(date_dir, drive) {
    rig_ = drive_.rig();
  }
  int frames() const override { return drive_.frames(); }
  SequenceFrame frame(int index) const override {
    SequenceFrame frame{drive_.left(index), drive_.right(index), {}, {}};
    if (index > 0 && drive_.hasLidar(index)) frame.truth_px = lidarTruth(drive_, index);
    return frame;
  }
  double stamp_s(int index) const override {
    if (stamps_ns_.empty())
      stamps_ns_ = drive_.stamps(KittiDrive::imageFolder(drive_.leftCamera()));
    return 1e-9 * static_cast<double>(stamps_ns_.at(static_cast<size_t>(index)));
  }
  int fileNumber(int index) const override { return drive_.fileNumber(index); }
  std::optional<std::vector<Eigen::Isometry3d>> poses() const override { return drive_.poses(); }

 private:
  KittiDrive drive_;
  mutable std::vector<int64_t> stamps_ns_;  ///< read on first use
};

// Where a benchmark has the files of its scenes.
struct Layout {
  const char *left, *right, *truth, *calibration, *P_left, *P_right;
  const char* vehicles;  // map of those that move; nullptr: nothing moves
};
constexpr Layout k2012 = {"image_0", "image_1", "disp_occ", "calib", "P0", "P1", nullptr};
constexpr Layout k2015 = {"image_2",   "image_3",   "disp_occ_0", "calib_cam_to_cam",
                          "P_rect_02", "P_rect_03", "obj_map"};

const Layout& layoutOf(KittiStereo benchmark) {
  return benchmark == KittiStereo::k2012 ? k2012 : k2015;
}

class KittiScene : public Sequence {
 public:
  KittiScene(const Layout& layout, const std::string& training_dir, const std::string& scene)
      : Sequence(scene), layout_(layout), dir_(training_dir) {
    if (!fs::is_directory(dir_)) throw std::runtime_error(dir_ + ": folder not found");
    const KittiCalibrationFile calibration(dir_ + "/" + layout.calibration + "/" + scene + ".txt");
    const auto hasPair = [&](int number) {
      return fs::is_regular_file(file(layout.left, number)) &&
             fs::is_regular_file(file(layout.right, number));
    };
    first_ = kTruthFile + 1;
    while (first_ > 0 && hasPair(first_ - 1)) --first_;
    if (frames() == 0)
      throw std::runtime_error(file(layout.left, kTruthFile) + ": the file, or that in " +
                               layout.right + ", is missing; unpack the scene again");
    rig_ = StereoRig::fromProjections(calibration.projection(layout.P_left),
                                      calibration.projection(layout.P_right),
                                      picture(layout.left, first_).size());
  }
  int frames() const override { return kTruthFile - first_ + 1; }
  SequenceFrame frame(int index) const override {
    const int number = first_ + index;
    SequenceFrame frame{picture(layout_.left, number), picture(layout_.right, number), {}, {}};
    if (number != kTruthFile) return frame;
    const cv::Mat coded = picture(layout_.truth, number, CV_16UC1);
    coded.convertTo(frame.truth_px, CV_32F, 1.0 / 256);
    frame.truth_px.setTo(kNoTruth, coded == 0);
    if (layout_.vehicles) frame.vehicles = picture(layout_.vehicles, number) > 0;
    return frame;
  }

 private:
  static constexpr int kTruthFile = 10;  // number of the pair with truth

  std::optional<std::vector<ObjectLabel>> trueObjects(int) const override {
    if (layout_.vehicles) return std::nullopt;
    return std::vector<ObjectLabel>();
  }
  std::string file(const std::string& folder, int number) const {
    return dir_ + "/" + folder + "/" + name_ + cv::format("_%02d.png", number);
  }
  // Of the size of the first one.
  cv::Mat picture(const std::string& folder, int number, int type = CV_8UC1) const {
    return readPicture(file(folder, number), type, rig_.size);
  }

  const Layout& layout_;
  std::string dir_;
  int first_;  // number of the first pair
};

class StreetSequence : public Sequence {
 public:
  explicit StreetSequence(const StreetParams& params)
      : Sequence("street " + params.scene), street_(params) {
    rig_ = street_.rig();
  }
  int frames() const override { return street_.frames(); }
  double stamp_s(int index) const override { return street_.stampOf(index); }
  SequenceFrame frame(int index) const override {
    const StreetFrame& street = rendered(index);
    SequenceFrame frame{street.left, street.right, {}, {}};
    if (index == 0) return frame;
    frame.truth_px = street.disparity_px.clone();
    frame.truth_px.setTo(kNoTruth, street.disparity_px <= 0);
    return frame;
  }
  std::optional<std::vector<Eigen::Isometry3d>> poses() const override {
    std::vector<Eigen::Isometry3d> poses;
    for (int index = 0; index < street_.frames(); ++index) poses.push_back(street_.poseOf(index));
    return poses;
  }

 private:
  std::optional<std::vector<ObjectLabel>> trueObjects(int index) const override {
    return labelsOf(rendered(index));
  }
  const StreetFrame& rendered(int index) const {
    if (last_.index != index || last_.left.empty()) last_ = street_.render(index);
    return last_;
  }

  Street street_;
  mutable StreetFrame last_;  ///< callers ask for a frame's images and then for its objects
};

}  // namespace

std::unique_ptr<Sequence> kittiDriveSequence(const std::string& date_dir,
                                             const std::string& drive) {
  return std::make_unique<KittiDriveSequence>(date_dir, drive);
}

std::vector<std::string> listKittiScenes(KittiStereo benchmark, const std::string& training_dir) {
  const std::string folder = training_dir + "/" + layoutOf(benchmark).truth;
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

std::unique_ptr<Sequence> kittiScene(KittiStereo benchmark, const std::string& training_dir,
                                     const std::string& scene) {
  return std::make_unique<KittiScene>(layoutOf(benchmark), training_dir, scene);
}

std::unique_ptr<Sequence> streetSequence(const StreetParams& params) {
  return std::make_unique<StreetSequence>(params);
}

}  // namespace predictive_stereo
