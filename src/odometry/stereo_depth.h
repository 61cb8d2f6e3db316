#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "odometry/image_pyramid.h"
#include "predictive_stereo/row_alignment.h"

namespace predictive_stereo {

/// A point of the left image, found in the right one.
struct StereoMatch {
  /// In: where it is expected, negative: to be searched for over the whole range. Out: x_left -
  /// x_right [px], of images whose principal points may differ.
  float shift_px = -1;
  bool expected = false;    ///< in: whether shift_px holds an expectation
  float row_offset_px = 0;  ///< out: y_right - y_left, as found
  /// Out: where the true row offset is known to be r, the best estimate of the shift is shift_px +
  /// shift_by_row * (row_offset_px - r): on oblique edges the two errors go together.
  float shift_by_row = 0;
  float variance = 0;  ///< out: of shift_px, for image noise of one grey value [px^2]
  bool found = false;  ///< out
};

struct StereoSearch {
  int smallest_shift_px = -2;  ///< far points of rigs that squint
  int largest_shift_px = 128;
  /// Rows above and below the expected one that are searched.
  int row_radius_px = 2;
};

/// Finds `points` of the left image in the right one: normalised correlation at half resolution
/// along the row that `alignment` tells, then sub-pixel alignment in both directions. Results do
/// not depend on the number of threads.
void matchStereo(const ImagePyramid& left, const ImagePyramid& right, const RowAlignment& alignment,
                 const StereoSearch& search, const std::vector<cv::Point2f>& points,
                 std::vector<StereoMatch>& matches);

}  // namespace predictive_stereo
