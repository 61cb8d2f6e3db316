/// The loop of FreeSpace over one row of cells, compiled for every SIMD target and dispatched at
/// run time. Every target gives the same results, bit by bit.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// Variance of the depth in a past camera's frame of points on one row, see PastDepthNoise.
struct DepthNoiseOfRow {
  float fixed;
  float coupling[2];  ///< coefficients of x^0, x^1
  float rotation[3];  ///< coefficients of x^0, x^1, x^2

  /// Of the point z (x, y, 1) m [m^2].
  float variance(float x, float z) const {
    const float by_coupling = coupling[0] + x * coupling[1];
    const float by_rotation = rotation[0] + x * (rotation[1] + x * rotation[2]);
    return fixed + z * (2 * by_coupling + z * by_rotation);
  }
};

/// A past frame as one row of cells sees it.
struct PastSight {
  const float* H;                         ///< 4x4, column-major: maps (x, y, d, 1) to that frame
  const float *nearest_px, *farthest_px;  ///< see DepthCells; of the whole frame
  int stride, columns, rows;              ///< of these maps
  DepthNoiseOfRow noise;
};

/// Cells of one row; cell u is at pixel (first_x + step_x u, y).
struct SightRow {
  const float *disparity_px, *variance_px2;
  const float* width_px;  ///< of their obstacles, see obstacleWidths
  int cells, first_x, step_x, y;
  int lattice_step_px;    ///< of the past maps
  float cx_px, focal_px;  ///< direction of column x: (x - cx) / focal
  float disparity_times_depth;
};

/// Looking through: the past disparity is smaller by this many standard deviations of the
/// difference, which has these parts.
constexpr float kSightSigmas = 2;
constexpr float kMapSigma_px = 0.5f;  ///< of the past disparity, and of errors of both maps
constexpr float kScaleSigma = 0.02f;  ///< calibration, relative to the disparity
constexpr int kFewestThrough = 2;     ///< past frames that looked through
/// The matcher misses surfaces that are thinner than its windows.
constexpr float kThinnest_px = 20;

/// Compares the cells with past frames.
/// @param past  `count` frames, the last one first.
/// @param least_px  cells with smaller disparities are left out.
/// @param through_by  1 + index of the first frame that looked through, where kFewestThrough and
///   more did than saw the surface at its place later on; 0 elsewhere.
/// @param fixed  255 where a frame saw the surface at its place; 0 elsewhere.
void sightsRow(const SightRow& row, const PastSight* past, int count, float least_px,
               uint8_t* through_by, uint8_t* fixed);

}  // namespace predictive_stereo
