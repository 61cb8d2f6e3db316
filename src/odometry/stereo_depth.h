#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "imaging/image_pyramid.h"
#include "predictive_stereo/row_alignment.h"

namespace predictive_stereo {

/// A point of the left image and its match in the right one.
struct StereoMatch {
  int id = 0;             ///< of the caller, not used here
  cv::Point2f point;      ///< in: in the left image [px]
  bool expected = false;  ///< in: whether shift_px holds an expectation, which is tried first
  /// In: expected. Out: measured. x_left - x_right [px], not corrected for the principal points.
  float shift_px = 0;
  float row_offset_px = 0;  ///< out: y_right - y_left, measured
  /// Out: if the true row offset is known to be r, the best estimate of the shift is shift_px +
  /// shift_by_row * (row_offset_px - r). On oblique edges the two errors are correlated.
  float shift_by_row = 0;
  float shift_variance_px2 = 0;  ///< out: of that estimate, for image noise of one grey level
  bool found = false;            ///< out
};

struct StereoSearch {
  int smallest_shift_px = -2;  ///< for far points of rigs whose axes converge
  int largest_shift_px = 128;
  /// Rows above and below the expected one that are searched. 0 still finds points with an error of
  /// more than a pixel.
  int row_radius_px = 2;
};

/// Finds points of the left image in the right one: normalised correlation at half resolution along
/// the row that `alignment` gives, then sub-pixel alignment in both directions. Results do not
/// depend on the number of threads.
void matchStereo(const ImagePyramid& left, const ImagePyramid& right,
                 const RowOffsetModel& alignment, const StereoSearch& search,
                 std::vector<StereoMatch>& matches);

}  // namespace predictive_stereo
