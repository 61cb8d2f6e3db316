/// Filling the holes of a map, in SIMD, dispatched at run time. See fillHoles.
#pragma once

#include <cstddef>

namespace predictive_stereo {

struct HoleLimits {
  int max_length;
  float tolerance_px;
  float hidden_slack_px;  ///< an occlusion may exceed the difference of disparities by this
};

/// Over so many pixels the slope of a surface beside a hole is measured.
constexpr int kSlopeReach = 8;

/// Fills the holes of one row in place.
void fillHolesOfRow(int width, float smallest_valid, const HoleLimits& limits, float* row);

/// Fills the holes of columns in place.
/// @param top  first row, of `width` pixels.
/// @param stride  from row to row, in pixels.
void fillHolesOfColumns(float* top, ptrdiff_t stride, int width, int height, float smallest_valid,
                        const HoleLimits& limits);

}  // namespace predictive_stereo
