#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/long_residual.h"
#include "detection/obstacles.h"
#include "detection/point_tracks.h"
#include "detection/verification.h"

namespace predictive_stereo {

/// Connected groups of lattice points whose 5x5 mean residual is large and nearly all of one sign;
/// the largest one first.
/// @param residual_px, pair  see longResidual. Points of a group have the same pair of frames.
/// @param disparity_px  of the frame, in full resolution.
/// @param least_mean_px  least |mean residual| over 5x5 lattice points.
std::vector<std::vector<cv::Point>> groupResiduals(const cv::Mat1f& residual_px,
                                                   const cv::Mat1b& pair,
                                                   const cv::Mat1f& disparity_px,
                                                   float least_mean_px);

/// Obstacles whose mean residual is large and mostly of one sign, as lattice points with a
/// disparity and a residual. A far one hardly fills a square of 5x5 points, but has more points.
/// @param least_mean_px  least |mean residual| over an obstacle.
std::vector<std::vector<cv::Point>> shiftedObstacles(const Obstacles& obstacles,
                                                     const cv::Mat1f& residual_px,
                                                     const cv::Mat1f& disparity_px,
                                                     const DisparityRange& range,
                                                     float least_mean_px);

/// Finds objects that move along the line of sight, which changes the disparity but hardly the
/// image. Between two successive frames the change is too small. Therefore the current frame is
/// compared with frames farther back, as long as static points have not moved much in the image
/// since then: motion accumulates over frames, errors of disparities do not.
struct AlongChannel {
  std::vector<PastPair> pairs;  ///< the farthest one first
  cv::Mat1f residual_px;        ///< of each lattice point, see longResidual
  cv::Mat1b pair;

  /// @param past  past frames, the last one first; at least one.
  void compare(const FrameView& frame, const std::vector<PastFrame>& past);
  /// Adds the objects that it finds. Call after compare().
  void find(const FrameView& frame, Verification& verification) const;
};

}  // namespace predictive_stereo
