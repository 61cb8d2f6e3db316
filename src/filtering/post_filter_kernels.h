/// One row of the post-filters, in SIMD, dispatched at run time.
#pragma once

namespace predictive_stereo {

/// One output row of filterBySupport. `rows` are the input rows from two above to two below, null
/// where these lie outside the image.
void filterRowBySupport(const float* const rows[5], int width, float smallest_valid, float invalid,
                        int min_support, float* filtered);

/// One output row of median3x3. `rows` are the input rows from one above to one below, null where
/// these lie outside the image.
void medianOfRow(const float* const rows[3], int width, float smallest_valid, float invalid,
                 float* filtered);

struct HoleLimits {
  int max_width;
  float tolerance_px;
  float hidden_slack_px;  ///< by which what is hidden may be wider than the disparities' difference
};
/// fillHoles in one row, in place.
void fillHolesOfRow(int width, float smallest_valid, const HoleLimits& limits, float* row);

}  // namespace predictive_stereo
