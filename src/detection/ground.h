#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/scratch.h"
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
  /// How far below the camera the lowest surfaces are among those in `area` of the lattice, at
  /// least [m]; infinite where there are none.
  float lowestIn(const cv::Rect& area, Scratch<float>& work) const;
  /// How far below the camera the points of a lattice row are [m]; 0: not on a level surface.
  const float* below_m(int row) const { return below_m_[row]; }

 private:
  cv::Mat1f below_m_;  // the camera; 0: not level
};

}  // namespace predictive_stereo
