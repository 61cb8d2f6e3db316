#pragma once

#include <vector>

#include "imaging/image_pyramid.h"

namespace predictive_stereo {

/// A point tracked from one image to another.
struct Track {
  int id = 0;            ///< of the caller, not used here
  cv::Point2f origin;    ///< in: in the first image [px]
  cv::Point2f position;  ///< in: expected, out: found position in the second image [px]
  float scale = 1;       ///< in: expected size in the first image / that in the second
  bool found = false;    ///< out
  /// Out: variance of x and y [px^2] for image noise of one grey level.
  cv::Vec2f variance_px2;
};

/// Finds the points of one image in another, coarse to fine. Points are independent: the result
/// does not depend on the number of threads.
void trackPoints(const ImagePyramid& from, const ImagePyramid& to, std::vector<Track>& tracks);

}  // namespace predictive_stereo
