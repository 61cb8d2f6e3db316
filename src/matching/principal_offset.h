/// The offset of the principal points, as searches apply it.
#pragma once

#include <cmath>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// cx_left - cx_right in two parts. Whole pixels choose the right image's columns: the partner of
/// left column x at disparity d is column x - d - whole_px. The rest is subtracted from the
/// sub-pixel disparity, so that no image has to be interpolated. It is not negative: disparities
/// down to min_disparity, which belong to the farthest points, are searched whatever the offset is.
struct PrincipalOffset {
  int whole_px = 0;
  float fraction_px = 0;  ///< 0 <= fraction_px < 1

  /// @param offset_px  of images that it leaves partners, see leavesPartners(): within int.
  explicit PrincipalOffset(double offset_px) {
    constexpr double kNegligiblePx = 1e-3;  // of rounding: would cost a pixel of the range
    const double whole = std::floor(offset_px + kNegligiblePx);
    whole_px = static_cast<int>(whole);
    const double fraction = offset_px - whole;
    if (fraction > kNegligiblePx) fraction_px = static_cast<float>(fraction);
  }

  /// The range of x_left - x_right in whole pixels.
  DisparityRange columnShifts(const DisparityRange& range) const {
    return {range.min_disparity + whole_px, range.count};
  }
};

}  // namespace predictive_stereo
