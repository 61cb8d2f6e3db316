/// The loop of longResidual over one row of points, compiled for every SIMD target and dispatched
/// at run time. Every target gives the same results, bit by bit.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace predictive_stereo {

/// Computes the parallax to a past camera, from its position in the current camera's frame and the
/// rig.
struct PastCamera {
  float x_m, y_m, z_m;
  float focal_px, cx_px, cy_px, disparity_times_depth;

  /// See parallaxSince.
  float parallax(float x, float y, float d) const {
    const float depth = disparity_times_depth - d * z_m;  // past depth times d
    const float across = std::abs((x - cx_px) * z_m - focal_px * x_m);
    const float down = std::abs((y - cy_px) * z_m - focal_px * y_m);
    const float moved = d * std::max(across, down) / depth;
    return depth > 0 ? moved : std::numeric_limits<float>::infinity();
  }
};

/// A past frame: H, 4x4 and column-major, maps static points (x, y, d) of the current frame to it
/// (see SourceOf); and its measured disparities.
struct PastDisparities {
  const float* H;
  const float* disparity_px;
  int stride, columns, rows;  ///< of that map
};

struct PastPairOfRow {
  PastCamera camera;
  PastDisparities past, halfway;
  float scale;  ///< time since the past frame / time since the halfway frame
};

constexpr int kLongStep_px = 4;  ///< between the points of a row
struct LongRow {
  const float* disparity_px;  ///< of the first point; the others follow at kLongStep_px
  int y, points;
  const PastPairOfRow* pairs;
  int pair_count;
  float smallest_valid_px, most_parallax_px;
};
constexpr float kLargestResidual_px = 8;  ///< larger ones count as this one
constexpr float kUnknownResidual = -1e6f;
constexpr uint8_t kNoPair = 255;

/// Residual and pair of each point, see longResidual.
void longResidualRow(const LongRow& row, float* residual_px, uint8_t* pair);

}  // namespace predictive_stereo
