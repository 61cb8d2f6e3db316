#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "detection/frame_history.h"
#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

constexpr float kUnknownResidual = -1e6f;
constexpr uint8_t kNoPair = 255;

/// A past frame, and the frame halfway between it and the current one.
struct PastPair {
  PastFrame past, halfway;
};

/// Signed residual of motion along the line of sight of each cell [px]: the disparity that a static
/// point would have had in the past, minus the one measured there.
///
/// Uses the first pair with a parallax (the point's motion in the image but for the camera's
/// rotation) of at most `most_px`; with more parallax another surface was often visible at that
/// position. The halfway frame must confirm it, with the same sign and half the size: motion
/// accumulates over frames, errors of disparities do not.
/// @param cells_px  DepthCells::disparity_px.
/// @param range  of the past frames' disparities.
/// @param pairs  the farthest one first.
/// @param residual_px  kUnknownResidual where a disparity is unknown.
/// @param pair  index of the pair of each cell, or kNoPair.
void longResidual(const StereoRig& rig, const cv::Mat1f& cells_px, const DisparityRange& range,
                  const std::vector<PastPair>& pairs, double most_px, cv::Mat1f& residual_px,
                  cv::Mat1b& pair);

}  // namespace predictive_stereo
