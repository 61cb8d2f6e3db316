#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// Lattice points (every second pixel and row) on level ground. There the disparity grows from row
/// to row as on a level surface; layerIn() separates the ground from higher surfaces such as
/// bonnets and steps. The optical axis is assumed to be level; a camera that looks down finds less
/// ground.
class LevelGround {
 public:
  /// Finds the level surfaces of a frame.
  void setFrame(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px);
  /// Whether a lattice point is on a level surface of any height: the road and its shadows, but
  /// hardly any point of the objects on it. False before the first frame.
  bool isLevel(cv::Point point) const { return !below_m_.empty() && below_m_(point) > 0; }
  /// 255 on the lattice points in `area` whose disparity is in the layer and that are not ground.
  /// @param farthest_px, nearest_px  of the layer, both included.
  cv::Mat1b layerIn(const cv::Rect& area, const cv::Mat1f& disparity_px, float farthest_px,
                    float nearest_px) const;
  /// Distance of the points of a lattice row below the camera [m]; 0: not on a level surface.
  const float* below_m(int row) const { return below_m_[row]; }

 private:
  float lowestIn(const cv::Rect& area) const;

  cv::Mat1f below_m_;  // distance below the camera; 0: not level
  int first_row_ = 0;  // below the horizon; rows above have no ground
};

}  // namespace predictive_stereo
