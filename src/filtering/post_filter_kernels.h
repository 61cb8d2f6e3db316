/// One row of the post-filters, in SIMD, dispatched at run time.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// Keys for the support test: integers in the order of the disparities. One subtraction and one
/// comparison then decide whether a disparity is between two others.
void supportKeysOfRow(const float* disparity_px, int width, float smallest_valid, int32_t* keys);
/// Key of unknown pixels, and of pixels outside the image: it is never between two others.
constexpr int32_t kNoSupportKey = INT32_MIN;

/// One output row of filterBySupport. `keys` are those of the rows from two above to two below,
/// with two more entries on both sides.
void filterRowBySupport(const float* disparity_px, const int32_t* const keys[5], int width,
                        float smallest_valid, float invalid, int min_support, float* filtered);

/// One output row of the 3x3 median. `rows` are the input rows from one above to one below, with
/// one more pixel on both sides; pixels outside the image are invalid.
void medianOfRow(const float* const rows[3], int width, float smallest_valid, float invalid,
                 float* filtered);

}  // namespace predictive_stereo
