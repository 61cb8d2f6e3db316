#pragma once

#include <vector>

#include "odometry/image_pyramid.h"

namespace predictive_stereo {

/// A point followed from one image to another.
struct Track {
  cv::Point2f position;    ///< in: where it is expected, out: where it was found [px]
  float scale = 1;         ///< in: expected size in the first image by that in the second
  float correlation = 0;   ///< out: zero-mean normalised correlation of the patches
  cv::Matx22f covariance;  ///< out: of `position`, for image noise of one grey value [px^2]
  bool found = false;      ///< out
};

/// Finds `points` of one image in the other, coarse to fine. Every point is treated by itself: the
/// result does not depend on the number of threads.
void trackPoints(const ImagePyramid& from, const ImagePyramid& to,
                 const std::vector<cv::Point2f>& points, std::vector<Track>& tracks);

}  // namespace predictive_stereo
