/// The loop of fitRoadLine over its samples, compiled for every SIMD target and dispatched at run
/// time. Every target gives the same results.
#pragma once

namespace predictive_stereo {

/// Number of samples on a line, within 0.3 px and 3 %.
/// @param row, disparity_px  of `count` samples.
int countOnLine(const double* row, const double* disparity_px, int count, double horizon_row_px,
                double disparity_per_row);

}  // namespace predictive_stereo
