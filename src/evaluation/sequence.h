#pragma once

#include <algorithm>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/object_labels.h"
#include "evaluation/simulation/street.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

/// One stereo pair with its disparity truth, if there is one.
struct SequenceFrame {
  cv::Mat1b left, right;
  cv::Mat1f truth_px;  ///< kNoTruth on pixels without truth; empty: no truth in this frame
  cv::Mat1b vehicles;  ///< KITTI 2015: 255 on vehicles that move; others: empty
};

/// A stereo sequence for evaluation.
class Sequence {
 public:
  virtual ~Sequence() = default;
  /// Also that of its label file.
  const std::string& name() const { return name_; }
  const StereoRig& rig() const { return rig_; }
  virtual int frames() const = 0;
  /// @throws std::runtime_error with the file that cannot be read.
  virtual SequenceFrame frame(int index) const = 0;
  /// @throws std::runtime_error if the recording has stamps that cannot be read.
  virtual double stamp_s(int index) const { return 0.1 * index; }
  /// Number of the frame in label files.
  virtual int fileNumber(int index) const { return index; }
  /// The moving objects of a frame: its labels, or else its ground truth, if there is some.
  std::optional<std::vector<ObjectLabel>> objects(int index) const {
    return labels_ ? labelsOf(*labels_, fileNumber(index)) : trueObjects(index);
  }
  /// @param labels  of all frames, by fileNumber.
  void setLabels(std::vector<ObjectLabel> labels) { labels_ = std::move(labels); }
  /// True poses T_world_cam of the left camera's optical frame, if they are known.
  virtual std::optional<std::vector<Eigen::Isometry3d>> poses() const { return std::nullopt; }

 protected:
  explicit Sequence(const std::string& name, const StereoRig& rig = {}) : name_(name), rig_(rig) {}
  /// The moving objects of a frame, if the sequence has ground truth of them.
  virtual std::optional<std::vector<ObjectLabel>> trueObjects(int /*index*/) const {
    return std::nullopt;
  }

  const std::string name_;
  StereoRig rig_;

 private:
  std::optional<std::vector<ObjectLabel>> labels_;
};

/// Its number of frames, or `max_frames` if this is less; 0: no limit.
inline int framesOf(const Sequence& sequence, int max_frames) {
  return max_frames > 0 ? std::min(max_frames, sequence.frames()) : sequence.frames();
}

/// A pair of the sequence as input of the pipeline.
inline StereoFrame stereoFrame(const Sequence& sequence, int index, const SequenceFrame& images) {
  return {images.left, images.right, sequence.rig(), stampFromSeconds(sequence.stamp_s(index))};
}

/// A drive of KITTI's raw recordings. All frames with a scan have LiDAR truth, except the first
/// one.
std::unique_ptr<Sequence> kittiDriveSequence(const std::string& date_dir, const std::string& drive);

/// KITTI's stereo benchmarks. 2012: static scenes. 2015: with vehicles that move; mostly there is
/// one frame.
enum class KittiStereo { k2012, k2015 };

/// The training scenes with truth, six digits each, sorted; at least one.
/// @param training_dir  2012: the folder with image_0, image_1, calib and disp_occ; 2015: that with
///   image_2, image_3, disp_occ_0, obj_map and calib_cam_to_cam.
/// @throws std::runtime_error with the file or folder, and so does kittiScene().
std::vector<std::string> listKittiScenes(KittiStereo benchmark, const std::string& training_dir);

/// A scene. Its last frame has truth, that of 2015 also vehicles.
std::unique_ptr<Sequence> kittiScene(KittiStereo benchmark, const std::string& training_dir,
                                     const std::string& scene);

/// The synthetic street. All frames except the first one have dense truth, except in the sky.
std::unique_ptr<Sequence> streetSequence(const StreetParams& params);

}  // namespace predictive_stereo
