/// The disparities of a frame on a coarse grid, for all that needs surfaces instead of pixels.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Side of a cell [px]. Cell (u, v) covers the pixels from (kCellSide_px u, kCellSide_px v) on.
constexpr int kCellSide_px = 4;
/// Where a cell is measured, from its first pixel.
constexpr int kCellCentre_px = 2;
/// Distance of the lattice points [px]: every second pixel and row.
constexpr int kLatticeStep_px = 2;

class DepthCells {
 public:
  cv::Mat1f disparity_px;  ///< of each cell; 0: unknown
  cv::Mat1f variance_px2;  ///< of disparity_px
  cv::Mat1f lattice_px;    ///< of each lattice point; 0: unknown
  /// Largest and smallest known disparity of the 3x3 lattice points around each lattice point; 0:
  /// none is known.
  cv::Mat1f nearest_px, farthest_px;

  /// Overwrites the maps; buffers of the right size are reused.
  /// @param disparity_px, variance_px2  of one frame, in full resolution.
  void setFrame(const DisparityRange& range, const cv::Mat1f& disparity_px,
                const cv::Mat1f& variance_px2);

 private:
  cv::Mat1f or_none_px_;  // as lattice_px, but unknown: a large number
};

}  // namespace predictive_stereo
