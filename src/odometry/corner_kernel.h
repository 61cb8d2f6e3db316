/// FAST corners: pixels that differ, all in one direction, from nine successive ones of the sixteen
/// on a circle around them.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace predictive_stereo {

struct FastCorner {
  cv::Point position;
  int score;  ///< the largest threshold at which it is a corner
};

/// The corners of a part of an image whose score is larger than those of their eight neighbours:
/// those of cv::FAST with non-maximum suppression, for a fifth of its instructions. Pixels nearer
/// to the image's border than 3 px are none. Memory is kept from use to use.
class FastCorners {
 public:
  /// @param area  where, within the image.
  /// @param least_score  0..254, of those that can be asked for.
  void find(const cv::Mat1b& image, const cv::Rect& area, int least_score);
  /// Appends those whose score is at least `least_score`, row by row.
  void append(int least_score, std::vector<FastCorner>& corners) const;

 private:
  cv::Rect area_;
  std::vector<uint8_t> peaks_;  // 1 + score at the corners of area_, 0 elsewhere
};

}  // namespace predictive_stereo
