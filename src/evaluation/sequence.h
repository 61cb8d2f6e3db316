#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/object_labels.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/pipeline.h"
#include "simulation/street.h"

namespace predictive_stereo {

/// A part of the image of which figures are given of their own.
struct Region {
  std::string name;
  cv::Mat1b mask;  ///< 255 within
};

/// One stereo pair with its truth, as far as there is one.
struct SequenceFrame {
  cv::Mat1b left, right;
  cv::Mat1f truth_px;  ///< kNoTruth where there is none; empty: none in this frame
  std::vector<Region> regions;
};

/// A stereo sequence to evaluate on.
class Sequence {
 public:
  virtual ~Sequence() = default;
  virtual const std::string& name() const = 0;
  /// The recording it is made of, by which label files are named.
  virtual const std::string& recording() const { return name(); }
  virtual const StereoRig& rig() const = 0;
  virtual int frames() const = 0;
  /// @throws std::runtime_error that names the file which cannot be read.
  virtual SequenceFrame frame(int index) const = 0;
  /// @throws std::runtime_error where the recording has stamps that cannot be read.
  virtual double stamp_s(int index) const { return 0.1 * index; }
  /// The number by which label files know a frame.
  virtual int fileNumber(int index) const { return index; }
  /// The moving objects of a frame, where the sequence knows them by itself.
  virtual std::optional<std::vector<ObjectLabel>> objects(int /*index*/) const {
    return std::nullopt;
  }
  /// True poses T_world_cam of the left camera's optical frame, where they are known.
  virtual std::optional<std::vector<Eigen::Isometry3d>> poses() const { return std::nullopt; }
};

/// A pair of the sequence as the pipeline takes it.
StereoFrame stereoFrame(const Sequence& sequence, int index, const SequenceFrame& images);

/// A drive of KITTI's raw recordings; LiDAR truth in all frames with a scan but the first.
std::unique_ptr<Sequence> kittiDriveSequence(const std::string& date_dir, const std::string& drive);

/// A scene of KITTI 2012, in which nothing moves; truth in its last frame, with region "near
/// edges": within 5 px of a jump by more than 3 px.
std::unique_ptr<Sequence> kittiScene2012Sequence(const std::string& training_dir,
                                                 const std::string& scene);

/// The synthetic street; dense truth of all but the sky in all frames but the first. Regions, each
/// pixel in one of them: "moving" objects; "hidden", not seen by the right camera; "newly visible",
/// hidden or outside of the view in the previous frame; "near edges", within 5 px of a jump by more
/// than 3 px; and "smooth", the rest.
std::unique_ptr<Sequence> streetSequence(const StreetParams& params);

}  // namespace predictive_stereo
