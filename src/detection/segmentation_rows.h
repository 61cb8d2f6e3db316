/// The loops of segment() over one row of the lattice, compiled for every SIMD target and
/// dispatched at run time. Every target gives the same results, bit by bit.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// 255 on points whose disparity is within the layer and that are not ground.
/// @param disparity_px  of every pixel from the first point on: point u is pixel 2u.
/// @param farthest_px, nearest_px  both included.
/// @param below_m, lowest_m  see LevelGround: points at least `lowest_m` below the camera are
///   ground.
void layerRow(const float* disparity_px, const float* below_m, int width, float farthest_px,
              float nearest_px, float lowest_m, uint8_t* layer);

/// How much better an object's motion explains the images than a static world does: the difference
/// of mismatches, clamped to +-`most`; 0 if one of them is negative (unknown).
void supportRow(const float* by_static, const float* by_object, int width, float most,
                float* support);

/// 255 where the layer is not 0 and the support is above `above`; 0 elsewhere.
void supportedRow(const uint8_t* layer, const float* support, int width, float above,
                  uint8_t* supported);

/// Sets points outside the layer, and points with a support below `least`, to 0.
void dropRefutedRow(const uint8_t* layer, const float* support, int width, float least,
                    uint8_t* members);

}  // namespace predictive_stereo
