/// What matching a frame in the middle of a sequence starts from.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "evaluation/sequence.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

struct MatchingJob {
  cv::Mat1b left, right, aligned_right;
  cv::Mat1f truth_px;       ///< empty: unknown
  DisparityState previous;  ///< of the closed loop, before this frame
  CameraMotion motion;
  SearchRanges ranges;  ///< real ones: prediction united with half-resolution match
};

/// Frames that only start the loop.
constexpr int kFramesBefore = 2;

/// Runs the pipeline without detection over the first frames, and keeps what matching needed after
/// the first kFramesBefore of them.
/// @throws std::runtime_error where the camera's motion cannot be followed.
std::vector<MatchingJob> matchingJobs(const Sequence& sequence, const DisparityParams& params,
                                      int frames);

}  // namespace predictive_stereo
