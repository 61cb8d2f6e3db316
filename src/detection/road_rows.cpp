#include "detection/road_rows.h"

#include <cmath>
#include <cstdint>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/road_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

HWY_NOINLINE int countOnLine(const double* HWY_RESTRICT row,
                             const double* HWY_RESTRICT disparity_px, int count,
                             double horizon_row_px, double disparity_per_row) {
  int64_t on = 0;  // as wide as the compared values, so that compilers can vectorise
  for (int i = 0; i < count; ++i) {
    const double d = disparity_px[i];
    const double error = std::abs(d - disparity_per_row * (row[i] - horizon_row_px));
    on += error < 0.3 + 0.03 * d ? 1 : 0;
  }
  return static_cast<int>(on);
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(countOnLine);

int countOnLine(const double* row, const double* disparity_px, int count, double horizon_row_px,
                double disparity_per_row) {
  return HWY_DYNAMIC_DISPATCH(countOnLine)(row, disparity_px, count, horizon_row_px,
                                           disparity_per_row);
}

}  // namespace predictive_stereo
#endif
