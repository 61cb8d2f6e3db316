/// Where the points of one row were in a past frame, if they are static. Included once per SIMD
/// target.

#if defined(PREDICTIVE_STEREO_ROW_MOTION_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PREDICTIVE_STEREO_ROW_MOTION_INL_H_
#undef PREDICTIVE_STEREO_ROW_MOTION_INL_H_
#else
#define PREDICTIVE_STEREO_ROW_MOTION_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "detection/frame_comparison.h"

PREDICTIVE_STEREO_BEGIN_KERNELS;

/// Numerators and denominator of the position (x, y, d) in the past frame, and places in its map.
class RowMotion {
 public:
  HWY_INLINE RowMotion(const PastMap& past, int row)
      : stride_(past.stride), columns_(past.columns), rows_(past.rows) {
    const auto y = static_cast<float>(row);
    for (int k = 0; k < 4; ++k) {
      by_x_[k] = past.H[k];
      of_row_[k] = past.H[4 + k] * y;
      by_d_[k] = past.H[8 + k];
      constant_[k] = past.H[12 + k];
    }
  }
  HWY_INLINE float x(float x, float d) const { return at<0>(x, d); }
  HWY_INLINE float y(float x, float d) const { return at<1>(x, d); }
  HWY_INLINE float d(float x, float d) const { return at<2>(x, d); }
  HWY_INLINE float w(float x, float d) const { return at<3>(x, d); }

  /// Index of the point (column, line), rounded down; 0 if it is outside or `exists` is false.
  /// @param[out] is_inside  1, or 0.
  HWY_INLINE int32_t offset(float column, float line, bool exists, int32_t& is_inside) const {
    const bool inside = exists & (column >= 0) & (line >= 0) &
                        (column < static_cast<float>(columns_)) &
                        (line < static_cast<float>(rows_));
    is_inside = inside ? 1 : 0;
    const float usable_column = inside ? column : 0.0f, usable_line = inside ? line : 0.0f;
    return static_cast<int32_t>(usable_line) * stride_ + static_cast<int32_t>(usable_column);
  }

 private:
  template <int k>
  HWY_INLINE float at(float x, float d) const {
    return by_x_[k] * x + of_row_[k] + by_d_[k] * d + constant_[k];
  }

  float by_x_[4], of_row_[4], by_d_[4], constant_[4];
  int stride_, columns_, rows_;
};

PREDICTIVE_STEREO_END_KERNELS;

#endif
