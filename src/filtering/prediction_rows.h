/// The loops of the prediction over one row of pixels, compiled for every SIMD target and
/// dispatched at run time. Every target gives the same result.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// H of eq. 2 for the pixels of one row: component i of H (x, y, d, 1) is by_x[i] x + by_d[i] d +
/// constant[i].
struct RowMotion {
  float by_x[4], by_d[4], constant[4];
};

struct WarpLimits {
  int columns, rows;        ///< size of the image [px]
  float smallest, largest;  ///< disparities that are kept [px]
};

/// Where the pixels of a row are warped to.
struct WarpedRow {
  int32_t* target;          ///< index of the pixel in the current frame; -1: outside
  float* disparity_px;      ///< in the current frame
  float* variance_px2;      ///< in the current frame: Phi^2 p
  int first_row, last_row;  ///< of the targets; first_row > last_row: none
};
void warpRow(const RowMotion& motion, const float* disparity_px, const float* variance_px2,
             const WarpLimits& limits, WarpedRow& warped);

/// One row of a prediction.
template <class Float, class Byte>
struct PredictionRow {
  Float* disparity_px;
  Float* variance_px2;
  Byte* missed_frames;
};
using ConstPredictionRow = PredictionRow<const float, const uint8_t>;
using MutablePredictionRow = PredictionRow<float, uint8_t>;

/// Fills an invalid pixel with the average of `before` and `after` if both are valid; missed_frames
/// is the larger of the two. All three may be parts of one row, one pixel apart.
void fillBetween(const ConstPredictionRow& before, const ConstPredictionRow& after, int width,
                 float smallest_valid, const MutablePredictionRow& filled);

/// Marks (255) pixels that differ from their right or their lower neighbour by more than `jump_px`.
void markEdges(const float* row, const float* row_below, int width, float jump_px,
               float smallest_valid, uint8_t* edges);

/// united |= marks, pixel by pixel.
void uniteMarks(const uint8_t* marks, int width, uint8_t* united);

/// Process noise of one row: floor + d^2 (J / d) Sigma (J / d)^T with J / d = (d / fb, y_n, -x_n)
/// up to sign.
struct RowNoise {
  float floor_px2;
  float zz, yy, xx;             ///< variances; factors of y_n are included
  float zy, zx, yx;             ///< twice the covariances; factors of y_n are included
  float per_fb;                 ///< 1 / (fx baseline)
  float per_fx, centre_column;  ///< x_n = (x - centre_column) per_fx
};

/// Adds the process noise to the variance of valid pixels; near edges it becomes `reset_px2`.
void addNoiseOrReset(const RowNoise& noise, const float* disparity_px, const uint8_t* near_edge,
                     int width, float smallest_valid, float reset_px2, float* variance_px2);

}  // namespace predictive_stereo
