#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/frame_history.h"
#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// A past frame and one in the middle between it and the current frame.
struct PastPair {
  PastFrame past, halfway;
};

/// How far a static point (x, y, d) has moved in the image since then, beside what the camera's
/// rotation moved all points by [px]; infinite where it was behind the camera.
float parallaxSince(const StereoRig& rig, const PastFrame& past, const Eigen::Vector3f& point_px);

constexpr uchar kNoPair = 255;
constexpr float kUnknownResidual = -1e6f;

/// Signed evidence of motion along the line of sight, on the lattice of compareFrames [px]: the
/// disparity that a static point had in the past, less what was measured there, of the first pair
/// with a parallax of at most `most_px`: beyond that, what was seen at its place was often
/// something else. The frame halfway has to agree: the residual has the same sign there, and half
/// the size. Errors of measured disparities do not accumulate over frames, motion does. Found for
/// every second lattice point and row, which stand for their neighbours.
/// @param pairs  the farthest first.
/// @param residual_px  kUnknownResidual where a disparity is unknown.
/// @param pair  of each lattice point, or kNoPair.
void longResidual(const StereoRig& rig, const cv::Mat1f& disparity_px, const DisparityRange& range,
                  const std::vector<PastPair>& pairs, double most_px, cv::Size lattice,
                  cv::Mat1f& residual_px, cv::Mat1b& pair);

}  // namespace predictive_stereo
