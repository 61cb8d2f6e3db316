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

/// The obstacle that an object is a part of. A walker's leg that stands does not move as his body
/// does, and trousers without texture show no motion.
/// @returns its number. -1 if the part is too small, or if too few of them have moved into free
///   space: static things have grown together with the object.
int wholeObstacle(const Observation& part, const Obstacles& obstacles,
                  const FreeSpaceEvidence& evidence);

/// Finds whole obstacles that have moved to where the camera has looked through before. Needs
/// neither texture nor tracks; motion may be large. An obstacle that has grown together with static
/// ones is left to the other channels.
class FreeSpaceChannel {
 public:
  /// Finds the objects of this frame, and remembers it. If most obstacles contradict the past, its
  /// pose is taken for wrong: the past is forgotten, and nothing is found.
  /// @param frame  with a pose.
  /// @param cells  those of the frame. nearest_px and farthest_px are taken over.
  std::vector<Observation> find(const FrameView& frame, DepthCells& cells);
  /// Extends an object that another channel found in this frame to the whole, see wholeObstacle, if
  /// that is plausible.
  void complete(const FrameView& frame, Observation& part) const;
  /// See FreeSpace.
  void addToDisparities(double step_px) {
    free_space_.addToDisparities(static_cast<float>(step_px));
  }
  /// Forgets the past frames.
  void reset() {
    free_space_.reset();
    pose_fits_ = false;
  }

 private:
  FreeSpace free_space_;
  bool pose_fits_ = false;  // of this frame
};

}  // namespace predictive_stereo
