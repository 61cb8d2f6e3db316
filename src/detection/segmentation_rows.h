/// The loops of segment() over one row of the lattice, compiled for every SIMD target and
/// dispatched at run time. Every target gives the same results, bit by bit.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// 255 on points whose disparity lies within the layer, and that are no ground.
/// @param disparity_px  of every pixel from the first point on: point u is pixel 2u.
/// @param farthest_px, nearest_px  both included.
/// @param below_m, lowest_m  see LevelGround: what is at least `lowest_m` below the camera is
/// ground.
void layerRow(const float* disparity_px, const float* below_m, int width, float farthest_px,
              float nearest_px, float lowest_m, uint8_t* layer);

/// By how much an object's motion explains the images better than the static world: the difference
/// of mismatches, at most `most` either way; 0 where one is negative (unknown).
void supportRow(const float* by_static, const float* by_object, int width, float most,
                float* support);

/// 255 where the layer is not 0 and the support more than `above`; 0 elsewhere.
void supportedRow(const uint8_t* layer, const float* support, int width, float above,
                  uint8_t* supported);

/// Sets points to 0 that are outside of the layer, or whose support is less than `least`.
void dropRefutedRow(const uint8_t* layer, const float* support, int width, float least,
                    uint8_t* members);

}  // namespace predictive_stereo
