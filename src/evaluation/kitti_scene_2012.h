#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// A scene of the KITTI 2012 stereo and flow benchmark (training): some consecutive grey pairs, one
/// of them with dense disparity truth.
///
/// Every failure is a std::runtime_error with the name of the file.
class KittiScene2012 {
 public:
  static constexpr int kTruthFile = 10;  ///< number of the pair with truth: NNNNNN_10.png

  /// @param training_dir  the folder with image_0, image_1, calib and disp_occ.
  /// @param scene  six digits, e.g. "000027".
  KittiScene2012(const std::string& training_dir, const std::string& scene);

  /// All scenes of a folder with truth, sorted.
  static std::vector<std::string> list(const std::string& training_dir);

  const std::string& name() const { return name_; }
  const StereoRig& rig() const { return rig_; }
  /// Number of consecutive pairs up to the one with truth, which is the last: frame frames() - 1.
  int frames() const { return frames_; }
  cv::Mat1b left(int frame) const { return image("image_0", frame); }
  cv::Mat1b right(int frame) const { return image("image_1", frame); }

  /// Disparity truth of the last frame [px]; kNoTruth on pixels without truth.
  /// @param occluded  include pixels that the right camera does not see.
  cv::Mat1f truth(bool occluded = true) const;

 private:
  std::string file(const std::string& folder, int frame) const;
  cv::Mat1b image(const std::string& folder, int frame) const;

  std::string dir_;
  std::string name_;
  StereoRig rig_;
  int frames_ = 0;
};

}  // namespace predictive_stereo
