#pragma once

#include <vector>

#include "odometry/image_pyramid.h"

namespace predictive_stereo {

/// A point followed from one image to another.
struct Track {
  int id = 0;            ///< the caller's
  cv::Point2f origin;    ///< in: in the first image [px]
  cv::Point2f position;  ///< in: where it is expected in the second, out: where it was found [px]
  float scale = 1;       ///< in: expected size in the first image by that in the second
  bool found = false;    ///< out
  /// Out: of the position's x and y, for image noise of one grey value [px^2].
  cv::Vec2f variance_px2;
};

/// Finds the points of one image in another, coarse to fine. Every point is treated by itself: the
/// result does not depend on the number of threads.
void trackPoints(const ImagePyramid& from, const ImagePyramid& to, std::vector<Track>& tracks);

}  // namespace predictive_stereo
