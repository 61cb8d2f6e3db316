#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/frame_comparison.h"
#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

constexpr float kUnknownResidual = -1e6f;

/// Signed evidence of motion along the line of sight, on the lattice of compareFrames [px]: where
/// the prediction forward (measured - predicted) and the one backward (static source - previous
/// measurement) agree in sign, the smaller of both; kUnknownResidual where one is unknown.
/// @param row  of the whole lattice; its row of `residual_px`, which has the lattice's size, is
///   written.
void denseResidualRow(const DetectionInput& input, const DisparityRange& range,
                      const LatticeRow& row, const RowSources& sources,
                      const cv::Mat1f& previous_disparity_px, cv::Mat1f& residual_px);

/// Connected groups of lattice points around which the residual's 7x7 mean is large and nearly
/// all of one sign.
struct DenseGroup {
  std::vector<cv::Point> points;  ///< lattice
  float disparity_px = 0;         ///< median
};
class DenseGroups {
 public:
  /// The largest first. Valid until the next call.
  const std::vector<DenseGroup>& find(const cv::Mat1f& residual_px, const cv::Mat1f& disparity_px,
                                      const MotionDetectionParams& params);
  /// The same for longResidual; points of a group have the same pair of frames. What is slow may be
  /// narrow: windows of 5x5 points.
  const std::vector<DenseGroup>& findSlow(const cv::Mat1f& residual_px, const cv::Mat1b& pair,
                                          const cv::Mat1f& disparity_px,
                                          const MotionDetectionParams& params);

 private:
  const std::vector<DenseGroup>& connect(const cv::Mat1f& disparity_px);
  cv::Mat1b seeds_;
  std::vector<float> outside_;  // a row of the map's surroundings
  std::vector<int> seeds_of_row_;
  std::vector<cv::Point> open_;
  std::vector<DenseGroup> groups_;
};

}  // namespace predictive_stereo
