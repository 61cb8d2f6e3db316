#include "detection/segmentation_rows.h"

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/segmentation_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

// Short loops without branches, which compilers vectorise.

HWY_NOINLINE void layerRow(const float* HWY_RESTRICT disparity_px,
                           const float* HWY_RESTRICT below_m, int width, float farthest_px,
                           float nearest_px, float lowest_m, uint8_t* HWY_RESTRICT layer) {
  for (int u = 0; u < width; ++u) {
    const float d = disparity_px[2 * u];
    const int32_t inside = (d >= farthest_px) & (d <= nearest_px) & (below_m[u] < lowest_m);
    layer[u] = static_cast<uint8_t>(-inside);
  }
}

HWY_NOINLINE void supportRow(const float* HWY_RESTRICT by_static,
                             const float* HWY_RESTRICT by_object, int width, float most,
                             float* HWY_RESTRICT support) {
  for (int u = 0; u < width; ++u) {
    const float difference = by_static[u] - by_object[u];
    const float lower = difference < most ? difference : most;
    const float clamped = lower > -most ? lower : -most;
    support[u] = (by_static[u] < 0) | (by_object[u] < 0) ? 0.0f : clamped;
  }
}

HWY_NOINLINE void supportedRow(const uint8_t* HWY_RESTRICT layer, const float* HWY_RESTRICT support,
                               int width, float above, uint8_t* HWY_RESTRICT supported) {
  for (int u = 0; u < width; ++u) {
    const int32_t inside = support[u] > above;
    supported[u] = static_cast<uint8_t>(-(inside & (layer[u] != 0)));
  }
}

HWY_NOINLINE void dropRefutedRow(const uint8_t* HWY_RESTRICT layer,
                                 const float* HWY_RESTRICT support, int width, float least,
                                 uint8_t* HWY_RESTRICT members) {
  for (int u = 0; u < width; ++u) {
    const int32_t refuted = support[u] < least;
    members[u] =
        static_cast<uint8_t>(members[u] & (-static_cast<int>((layer[u] != 0)) & ~-refuted));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(layerRow);
HWY_EXPORT(supportRow);
HWY_EXPORT(supportedRow);
HWY_EXPORT(dropRefutedRow);

void layerRow(const float* disparity_px, const float* below_m, int width, float farthest_px,
              float nearest_px, float lowest_m, uint8_t* layer) {
  HWY_DYNAMIC_DISPATCH(layerRow)
  (disparity_px, below_m, width, farthest_px, nearest_px, lowest_m, layer);
}

void supportRow(const float* by_static, const float* by_object, int width, float most,
                float* support) {
  HWY_DYNAMIC_DISPATCH(supportRow)(by_static, by_object, width, most, support);
}

void supportedRow(const uint8_t* layer, const float* support, int width, float above,
                  uint8_t* supported) {
  HWY_DYNAMIC_DISPATCH(supportedRow)(layer, support, width, above, supported);
}

void dropRefutedRow(const uint8_t* layer, const float* support, int width, float least,
                    uint8_t* members) {
  HWY_DYNAMIC_DISPATCH(dropRefutedRow)(layer, support, width, least, members);
}

}  // namespace predictive_stereo
#endif
