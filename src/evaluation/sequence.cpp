#include "evaluation/sequence.h"

#include "evaluation/disparity_metrics.h"
#include "evaluation/lidar_truth.h"
#include "predictive_stereo/rigid_motion.h"
#include "tools/kitti_drive.h"

namespace predictive_stereo {
namespace {

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

std::unique_ptr<Sequence> streetSequence(const StreetParams& params) {
  return std::make_unique<StreetSequence>(params);
}

}  // namespace predictive_stereo
