/// The loops of compareFrames over one row of the lattice, compiled for every
/// SIMD target and dispatched at run time. Every target gives the same results, bit by bit.
#pragma once

#include <cstdint>
#include <opencv2/core/utility.hpp>

namespace predictive_stereo {

/// Lattice points of one row, and their motion into a previous frame.
struct LatticeRow {
  const float* H;             ///< 4x4, column-major: maps (x, y, d, 1) to the previous frame
  const float* disparity_px;  ///< of the first point; the next one is two floats further
  int x, y;                   ///< pixel of the first point
  int width;                  ///< points
  float smallest_px;          ///< points with smaller disparities are left out
  int columns, rows;          ///< of the previous image at half resolution
};

/// Positions of a row's points in the previous frame.
class RowSources {
 public:
  explicit RowSources(int width) : width_(width), memory_(3 * static_cast<size_t>(width)) {}

  /// [px]; (0, 0) if the point is not seen.
  float* x() { return memory_.data(); }
  float* y() { return x() + width_; }
  /// 1, or 0 for points without a disparity and those outside of the previous image.
  float* seen() { return y() + width_; }
  const float* x() const { return memory_.data(); }
  const float* y() const { return x() + width_; }
  const float* seen() const { return y() + width_; }

 private:
  int width_;
  cv::AutoBuffer<float, 4096> memory_;
};
void projectRow(const LatticeRow& row, RowSources& sources);

/// Current grey value - previous grey value.
/// @param grey  current grey values of the row's points.
/// @param before  the previous image at half resolution, continuous in memory.
/// @param difference  0 where unknown.
/// @param known  1, or 0 where unknown.
void compareRow(const LatticeRow& row, const RowSources& sources, const uint8_t* grey,
                const uint8_t* before, float* difference, float* known);

/// Side of the squares over which comparisons are summed, and their reach from the centre.
constexpr int kComparedSide = 5, kComparedReach = kComparedSide / 2;

/// Rows from kComparedReach above to kComparedReach below, each with kComparedReach more points
/// before its first and after its last one. They are 0 outside the map.
using SurroundingRows = const float* const*;

/// |difference - its mean over the known points of the square|, 0 where unknown, and the number of
/// known points of the square.
void deviationRow(SurroundingRows difference, SurroundingRows known, int width, float* deviation,
                  float* count);

/// Mean deviation of the known points of the square; kUnknownMismatch if the point itself is not
/// known, or if fewer than half of them are.
constexpr float kUnknownMismatch = -1;
void mismatchRow(SurroundingRows deviation, const float* known, const float* count, int width,
                 float* mismatch);

}  // namespace predictive_stereo
