#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// Lattice points (every second pixel and row) on level ground: where the disparity grows from row
/// to row as on a level surface, and as low as most of these surfaces do, so that bonnets and steps
/// are left out. The optical axis is taken as level; of a camera that looks down, less is found.
class LevelGround {
 public:
  /// Finds the level surfaces of a frame.
  void setFrame(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px);
  /// Whether a lattice point lies on a level surface of any height: the road and its shadows, but
  /// hardly anything of what moves on it. False before the first frame.
  bool isLevel(cv::Point point) const { return !below_m_.empty() && below_m_(point) > 0; }
  /// Of the lowest ones among those in `area` of the lattice.
  /// @param ground  255 on them; of the area's size.
  void find(const cv::Rect& area, cv::Mat1b& ground);

 private:
  cv::Mat1f below_m_;  // the camera; 0: not level
  std::vector<float> of_area_m_;
};

}  // namespace predictive_stereo
