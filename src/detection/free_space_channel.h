#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/depth_cells.h"
#include "detection/free_space.h"
#include "detection/observation.h"
#include "detection/obstacles.h"

namespace predictive_stereo {

/// The cells of an obstacle's object, in full resolution: their pixels with their disparity.
/// @param area  the smallest box around the cells.
ObservedObject objectOf(const Obstacles::Cells& obstacle, const cv::Rect& area,
                        const DepthCells& cells, const DisparityRange& range,
                        const cv::Mat1f& disparity_px);

/// The obstacle that an object is a part of. A walker's leg that stands does not move as his body
/// does, and trousers without texture show no motion.
/// @returns its cells. None if the part is too small, or if too few of them have moved into free
///   space: static things have grown together with the object.
Obstacles::Cells wholeObstacle(const ObservedObject& part, const Obstacles& obstacles,
                               const FreeSpaceEvidence& evidence);

/// The pixels of both, without thin ends of the whole: what a matcher adds at silhouettes.
/// Observation is that of the part, but for box_px.
ObservedObject joined(const ObservedObject& part, const ObservedObject& whole);

/// Finds whole obstacles that have moved to where the camera has looked through before. Needs
/// neither texture nor tracks; motion may be large. An obstacle that has grown together with static
/// ones is left to the other channels.
class FreeSpaceChannel {
 public:
  /// Measures the surfaces of a frame.
  void setFrame(const DetectionInput& input, const DisparityRange& range);
  /// Of this frame; no ground: it shows none. nearest_px and farthest_px of the cells are only
  /// known until find().
  const DepthCells& cells() const { return cells_; }
  const std::optional<GroundPlane>& ground() const { return ground_.plane(); }
  /// Finds the objects of this frame, and remembers it. If most obstacles contradict the past, its
  /// pose is taken for wrong: the past is forgotten, and nothing is found.
  /// @param input  with a pose.
  /// @param half_image  the left image on the lattice.
  std::vector<ObservedObject> find(const DetectionInput& input, const DisparityRange& range,
                                   const MotionDetectionParams& params,
                                   const cv::Mat1b& half_image);
  /// Extends an object that another channel found in this frame to the whole, see wholeObstacle, if
  /// that is plausible.
  void complete(const DetectionInput& input, const DisparityRange& range,
                const MotionDetectionParams& params, ObservedObject& part) const;
  /// See FreeSpace.
  void addToDisparities(double step_px) {
    free_space_.addToDisparities(static_cast<float>(step_px));
  }
  /// The past frames, of another pose than this one.
  void forgetPast() { free_space_.reset(); }
  void reset();

 private:
  bool isPossible(const StereoRig& rig, const MotionDetectionParams& params,
                  const Obstacles::Cells& obstacle, const cv::Rect& area, double distance_m) const;

  DepthCells cells_;
  FreeSpace free_space_;
  SteadyGround ground_;
  Obstacles obstacles_;  // of this frame; none if its pose is wrong
};

}  // namespace predictive_stereo
