#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/frame_history.h"
#include "detection/free_space.h"
#include "detection/observation.h"
#include "detection/obstacles.h"

namespace predictive_stereo {

/// The cells of an obstacle's object, in full resolution: their pixels with their disparity.
Observation objectOf(const FrameView& frame, const std::vector<cv::Point>& obstacle);

/// Finds whole obstacles that have moved to where the camera has looked through before. Needs
/// neither texture nor tracks; motion may be large. A fifth of an obstacle's cells is enough, as a
/// walker's leg that stands does not move. One that has grown together with much larger static ones
/// is left to the other channels.
class FreeSpaceChannel {
 public:
  /// Finds the objects of this frame, and remembers it. If most obstacles contradict the past, its
  /// pose is taken for wrong: the past is forgotten, and nothing is found.
  /// @param frame  with a pose.
  /// @param cells  those of the frame. nearest_px and farthest_px are taken over.
  std::vector<Observation> find(const FrameView& frame, DepthCells& cells);
  /// See FreeSpace.
  void addToDisparities(double step_px) {
    free_space_.addToDisparities(static_cast<float>(step_px));
  }
  /// Forgets the past frames.
  void reset() { free_space_.reset(); }

 private:
  FreeSpace free_space_;
};

}  // namespace predictive_stereo
