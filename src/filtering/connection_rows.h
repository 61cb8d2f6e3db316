/// Rows of the region filter, compiled for every SIMD target.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// connected[x]: 1 if both pixels are valid and differ by at most 1 px, else 0.
void connectionsOfRow(const float* pixels, const float* neighbours, int count, float smallest_valid,
                      uint8_t* connected);

}  // namespace predictive_stereo
