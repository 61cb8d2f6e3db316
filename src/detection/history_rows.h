/// The loops of DisparityHistory over points, compiled for every SIMD target and dispatched at run
/// time. Every target gives the same results, bit by bit.
#pragma once

#include <cstdint>

#include "detection/long_rows.h"

namespace predictive_stereo {

/// What differences of disparities cost, see DisparityHistory.
struct CostLimits {
  float sigma_px, sigma_per_disparity;  ///< of the difference of two
  float most, unknown;
  float smallest_valid_px;
};

/// Points (x, y, d) of the current frame.
struct PointRow {
  const float *x, *y, *d;
  int count;
};

/// What each point costs in a frame of the past, where then.H tells where it was.
void costRow(const PointRow& points, const PastDisparities& then, const CostLimits& limits,
             float* cost);

/// By how much moving points explain a frame of the past better than static ones.
/// @param static_H  as then.H, which is that of the moving ones.
/// @param gain  0 where unknown.
/// @param known  whether it is.
void gainRow(const PointRow& points, const float* static_H, const PastDisparities& then,
             const CostLimits& limits, float* gain, uint8_t* known);

}  // namespace predictive_stereo
