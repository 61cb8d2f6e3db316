/// Points that a static world does not explain.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/frame_history.h"

namespace predictive_stereo {

/// Texture around each lattice point: the mean over 5x5 points of |grey - mean grey over 5x5
/// points|. At its border the image is mirrored.
void greyTexture(const cv::Mat1b& grey, cv::Mat1f& texture);

struct Suspects {
  std::vector<cv::Point> points_px;  ///< at most one per cell of 4x4 lattice points, row by row
  double share = 0;  ///< of the image's cells, including those whose points were left out
};
/// Finds points whose image a static world does not explain: the mismatch of frames is large
/// relative to the texture around. Without texture a wrong motion is not visible. Points at edges
/// of the disparity are left out, as they cannot be tracked well, and those on the ground, as
/// shadows are no objects.
/// @param texture  see greyTexture; of the current image on the lattice.
/// @param mismatch  of the whole lattice, see compareFrames.
Suspects findSuspects(const FrameView& frame, const cv::Mat1f& texture, const cv::Mat1f& mismatch);

constexpr size_t kMostSuspects = 3000;

/// Drops points that a static world explains after all, with a slightly larger or smaller disparity
/// or with that of a neighbour: disparities of foliage, fences and edges are often wrong by this.
/// Also drops points that were occluded in the past frame.
/// @param points_px  on the lattice, at least 3 lattice points from its border.
/// @returns the other points, in their order. If there are more than kMostSuspects points, as when
///   ego-motion fails, only an even sample of them is used.
std::vector<cv::Point> unexplainedPoints(const PastView& view,
                                         const std::vector<cv::Point>& points_px);

}  // namespace predictive_stereo
