#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

/// A connected group of lattice points whose 5x5 mean residual is large and nearly all of one sign.
struct ResidualGroup {
  std::vector<cv::Point> points;  ///< lattice
  float disparity_px = 0;         ///< median
};
class ResidualGroups {
 public:
  /// @param residual_px, pair  see longResidual. Points of a group have the same pair of frames.
  /// @returns the groups, the largest one first; valid until the next call.
  const std::vector<ResidualGroup>& find(const cv::Mat1f& residual_px, const cv::Mat1b& pair,
                                         const cv::Mat1f& disparity_px,
                                         const MotionDetectionParams& params);

 private:
  const std::vector<ResidualGroup>& connect(const cv::Mat1f& disparity_px);
  cv::Mat1b seeds_;
  std::vector<int> seeds_of_row_;
  std::vector<cv::Point> open_;
  std::vector<ResidualGroup> groups_;
};

}  // namespace predictive_stereo
