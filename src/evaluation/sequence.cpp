#include "evaluation/sequence.h"

#include <algorithm>
#include <cmath>

#include "evaluation/disparity_metrics.h"
#include "evaluation/lidar_truth.h"
#include "predictive_stereo/rigid_motion.h"
#include "tools/kitti_drive.h"

namespace predictive_stereo {
namespace {

class KittiDriveSequence : public Sequence {
 public:
  KittiDriveSequence(const std::string& date_dir, const std::string& drive)
      : drive_(date_dir, drive) {}
  const std::string& name() const override { return drive_.name(); }
  const StereoRig& rig() const override { return drive_.rig(); }
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

/// 255 where a static surface was occluded or outside the image in the previous frame.
cv::Mat1b newlyVisible(const StreetFrame& previous, const StreetFrame& current,
                       const StereoRig& rig) {
  const Eigen::Isometry3d T_prev_cam = relative(previous.T_world_cam, current.T_world_cam);
  cv::Mat1b mask = cv::Mat1b::zeros(current.disparity_px.size());
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) {
      const float disparity_px = current.disparity_px(y, x);
      if (disparity_px <= 0) continue;
      const Eigen::Vector3d point_prev_m = T_prev_cam * rig.pointFromDisparity(x, y, disparity_px);
      mask(y, x) = 255;
      if (point_prev_m.z() <= 0) continue;
      const Eigen::Vector3d omega = rig.disparityFromPoint(point_prev_m);
      const long column = std::lround(omega.x()), row = std::lround(omega.y());
      if (column < 0 || row < 0 || column >= mask.cols || row >= mask.rows) continue;
      const float seen_px = previous.disparity_px(static_cast<int>(row), static_cast<int>(column));
      if (seen_px <= omega.z() + 1.0) mask(y, x) = 0;
    }
  return mask;
}

class StreetSequence : public Sequence {
 public:
  explicit StreetSequence(const StreetParams& params)
      : street_(params), name_("street " + params.scene) {}
  const std::string& name() const override { return name_; }
  const StereoRig& rig() const override { return street_.rig(); }
  int frames() const override { return street_.frames(); }

  double stamp_s(int index) const override { return street_.stampOf(index); }
  std::optional<std::vector<ObjectLabel>> objects(int index) const override {
    return labelsOf(previous_.index == index && !previous_.left.empty() ? previous_
                                                                        : street_.render(index));
  }

  SequenceFrame frame(int index) const override {
    if (index == 0 || previous_.index != index - 1 || previous_.left.empty())
      previous_ = street_.render(std::max(0, index - 1));
    StreetFrame current = index == 0 ? previous_ : street_.render(index);
    SequenceFrame frame{current.left, current.right, {}, {}};
    if (index > 0) {
      frame.truth_px = current.disparity_px.clone();
      frame.truth_px.setTo(kNoTruth, current.disparity_px <= 0);
      const cv::Mat1b moving = current.moving_id > 0;
      const cv::Mat1b hidden = current.occluded & ~moving;
      const cv::Mat1b fresh = newlyVisible(previous_, current, rig()) & ~(moving | hidden);
      const cv::Mat1b edges = nearTruthEdges(frame.truth_px) & ~(moving | hidden | fresh);
      const cv::Mat1b smooth = ~(moving | hidden | fresh | edges);
      frame.regions = {{"smooth", smooth},
                       {"near edges", edges},
                       {"newly visible", fresh},
                       {"hidden", hidden},
                       {"moving", moving}};
    }
    previous_ = std::move(current);
    return frame;
  }
  std::optional<std::vector<Eigen::Isometry3d>> poses() const override {
    std::vector<Eigen::Isometry3d> poses;
    for (int index = 0; index < street_.frames(); ++index) poses.push_back(street_.poseOf(index));
    return poses;
  }

 private:
  Street street_;
  std::string name_;
  mutable StreetFrame previous_;  ///< the last rendered frame: callers mostly go in order
};

}  // namespace

int framesOf(const Sequence& sequence, int max_frames) {
  return max_frames > 0 ? std::min(max_frames, sequence.frames()) : sequence.frames();
}

StereoFrame stereoFrame(const Sequence& sequence, int index, const SequenceFrame& images) {
  return {images.left, images.right, sequence.rig(), stampFromSeconds(sequence.stamp_s(index))};
}

std::unique_ptr<Sequence> kittiDriveSequence(const std::string& date_dir,
                                             const std::string& drive) {
  return std::make_unique<KittiDriveSequence>(date_dir, drive);
}

std::unique_ptr<Sequence> streetSequence(const StreetParams& params) {
  return std::make_unique<StreetSequence>(params);
}

}  // namespace predictive_stereo
