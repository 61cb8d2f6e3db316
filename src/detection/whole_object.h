/// From the part of an object that its motion shows to the whole object.
#pragma once

#include <opencv2/core.hpp>

#include "detection/depth_cells.h"
#include "detection/free_space.h"
#include "detection/obstacles.h"
#include "detection/tracker.h"

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

}  // namespace predictive_stereo
