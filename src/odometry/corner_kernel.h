/// FAST corners: pixels that differ, all in one direction, from nine successive ones of the sixteen
/// on a circle around them.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace predictive_stereo {

struct FastCorner {
  cv::Point position;
  int score;  ///< the largest threshold at which it is a corner
};

/// Finds the corners whose score is at least `threshold` and larger than those of their eight
/// neighbours: those of cv::FAST with non-maximum suppression, for a fifth of its instructions.
/// Pixels nearer to the image's border than 3 px are none.
/// @param area  where, within the image.
/// @param threshold  0..254.
/// @param corners  the found ones, appended row by row.
void findFastCorners(const cv::Mat1b& image, const cv::Rect& area, int threshold,
                     std::vector<FastCorner>& corners);

}  // namespace predictive_stereo
