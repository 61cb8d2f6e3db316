#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/long_residual.h"
#include "detection/obstacles.h"
#include "detection/point_tracks.h"
#include "detection/verification.h"

namespace predictive_stereo {

/// Connected groups of cells whose mean residual over 3x3 cells is large and mostly of one sign.
/// @param residual_px, pair  see longResidual. Cells of a group have the same pair of frames.
/// @param cells_px  DepthCells::disparity_px.
/// @param least_mean_px  least |mean residual| over 3x3 cells.
std::vector<std::vector<cv::Point>> groupResiduals(const cv::Mat1f& residual_px,
                                                   const cv::Mat1b& pair, const cv::Mat1f& cells_px,
                                                   float least_mean_px);

/// The cells of obstacles whose mean residual is large and mostly of one sign. A far one hardly
/// fills a square of 3x3 cells, but has more cells.
/// @param least_mean_px  least |mean residual| over an obstacle.
std::vector<std::vector<cv::Point>> shiftedObstacles(const Obstacles& obstacles,
                                                     const cv::Mat1f& residual_px,
                                                     float least_mean_px);

/// Finds objects that move along the line of sight, which changes the disparity but hardly the
/// image. Between two successive frames the change is too small. Therefore the current frame is
/// compared with frames farther back, as long as static points have not moved much in the image
/// since then: motion accumulates over frames, errors of disparities do not.
struct AlongChannel {
  std::vector<PastPair> pairs;  ///< the farthest one first
  cv::Mat1f residual_px;        ///< of each cell, see longResidual
  cv::Mat1b pair;

  /// @param past  past frames, the last one first; at least one.
  void compare(const FrameView& frame, const std::vector<PastFrame>& past);
  /// Adds the objects that it finds. Call after compare().
  void find(const FrameView& frame, Verification& verification) const;
};

}  // namespace predictive_stereo
