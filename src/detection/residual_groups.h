#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace predictive_stereo {

/// A connected group of lattice points whose 5x5 mean residual is large and nearly all of one sign.
struct ResidualGroup {
  std::vector<cv::Point> points;  ///< lattice
  float disparity_px = 0;         ///< median
};

/// @param residual_px, pair  see longResidual. Points of a group have the same pair of frames.
/// @param disparity_px  of the frame, in full resolution.
/// @param least_mean_px  least |mean residual| over 5x5 lattice points.
/// @returns the groups, the largest one first.
std::vector<ResidualGroup> groupResiduals(const cv::Mat1f& residual_px, const cv::Mat1b& pair,
                                          const cv::Mat1f& disparity_px, float least_mean_px);

}  // namespace predictive_stereo
