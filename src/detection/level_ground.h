#pragma once

#include <opencv2/core.hpp>

#include "detection/frame_comparison.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// Lattice points (every second pixel and row) on level ground. There the disparity grows from row
/// to row as on a level surface; lowestIn() separates the ground from higher surfaces such as
/// bonnets and steps. The optical axis is assumed to be level; a camera that looks down finds less
/// ground.
class LevelGround {
 public:
  /// Finds the level surfaces of a frame.
  void setFrame(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px);
  /// Whether a lattice point is on a level surface of any height: the road and its shadows, but
  /// hardly any point of the objects on it. False before the first frame.
  bool isLevel(cv::Point point) const { return !below_m_.empty() && below_m_(point) > 0; }
  /// Distance below the camera [m] from which on level surfaces in `area` of the lattice are
  /// ground; infinity if there are none.
  float lowestIn(const cv::Rect& area, Scratch<float>& work) const;
  /// Distance of the points of a lattice row below the camera [m]; 0: not on a level surface.
  const float* below_m(int row) const { return below_m_[row]; }

 private:
  cv::Mat1f below_m_;  // distance below the camera; 0: not level
};

}  // namespace predictive_stereo
