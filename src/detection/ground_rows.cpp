#include "detection/ground_rows.h"

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/ground_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

HWY_NOINLINE void levelRow(const float* HWY_RESTRICT disparity_px,
                           const float* const above[kMostGroundReach],
                           const float* const beneath[kMostGroundReach], int width,
                           const GroundLimits& limits, float* HWY_RESTRICT below_m) {
  static_assert(kMostGroundReach == 4, "written out");
  // A row outside the map is replaced by the point's own row, which has no growth.
  const auto row = [&](const float* rows) { return rows ? rows : disparity_px; };
  const float *a1 = row(above[0]), *a2 = row(above[1]), *a3 = row(above[2]), *a4 = row(above[3]);
  const float *b1 = row(beneath[0]), *b2 = row(beneath[1]), *b3 = row(beneath[2]),
              *b4 = row(beneath[3]);
  // Number of rows inside the map.
  const float reachable = above[3] && beneath[3]   ? 4.0f
                          : above[2] && beneath[2] ? 3.0f
                          : above[1] && beneath[1] ? 2.0f
                          : above[0] && beneath[0] ? 1.0f
                                                   : 0.0f;
  const float smallest = limits.smallest_px, by_disparity = limits.reach_by_disparity,
              horizon = limits.horizon_distance_px, baseline = limits.baseline_m,
              least = limits.least_share, most = limits.most_share;
  for (int u = 0; u < width; ++u) {
    const float d = disparity_px[2 * u];
    const float rows = by_disparity * d;
    const bool two = rows >= 2, three = rows >= 3, four = rows >= 4;
    const float upper1 = a1[2 * u], upper2 = a2[2 * u], upper3 = a3[2 * u], upper4 = a4[2 * u];
    const float lower1 = b1[2 * u], lower2 = b2[2 * u], lower3 = b3[2 * u], lower4 = b4[2 * u];
    float reach = two ? 2.0f : 1.0f, upper = two ? upper2 : upper1, lower = two ? lower2 : lower1;
    reach = three ? 3.0f : reach, upper = three ? upper3 : upper, lower = three ? lower3 : lower;
    reach = four ? 4.0f : reach, upper = four ? upper4 : upper, lower = four ? lower4 : lower;
    const float expected = 4 * reach * d / horizon;
    const float growth = lower - upper;
    const bool level = (reach <= reachable) & (d >= smallest) & (d > 0) & (upper >= smallest) &
                       (lower >= smallest) & (growth >= least * expected) &
                       (growth <= most * expected);
    below_m[u] = level ? horizon * baseline / d : 0.0f;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(levelRow);

void levelRow(const float* disparity_px, const float* const above[kMostGroundReach],
              const float* const beneath[kMostGroundReach], int width, const GroundLimits& limits,
              float* below_m) {
  HWY_DYNAMIC_DISPATCH(levelRow)(disparity_px, above, beneath, width, limits, below_m);
}

}  // namespace predictive_stereo
#endif
