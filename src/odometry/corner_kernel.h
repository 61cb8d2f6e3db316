/// FAST corners: pixels that are all darker, or all brighter, than nine successive ones of the
/// sixteen pixels on a circle around them.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace predictive_stereo {

struct FastCorner {
  cv::Point position;
  int score;  ///< the largest threshold at which it is a corner
};

/// The corners of a part of an image after non-maximum suppression. The result is that of cv::FAST,
/// with a fifth of its instructions. Pixels less than 3 px from the image's border are no corners.
/// Keeps its buffers between calls.
class FastCorners {
 public:
  /// @param area  part of the image to search.
  /// @param least_score  0..254: the smallest score that append() can be called with.
  void find(const cv::Mat1b& image, const cv::Rect& area, int least_score);
  /// Appends the corners with a score of at least `least_score`, row by row.
  void append(int least_score, std::vector<FastCorner>& corners) const;

 private:
  cv::Rect area_;
  std::vector<uint8_t> peaks_;  // 1 + score at the corners of area_, 0 elsewhere
};

}  // namespace predictive_stereo
