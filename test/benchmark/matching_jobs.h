/// Inputs of matching, for a frame in the middle of a sequence.
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
  SearchRanges ranges;  ///< of the pipeline: union of prediction and half-resolution match
};

/// Number of frames that only initialise the loop.
constexpr int kFramesBefore = 2;

/// Runs the pipeline without detection on the first frames, and returns the inputs of matching for
/// those after the first kFramesBefore.
/// @throws std::runtime_error if the ego-motion is lost.
std::vector<MatchingJob> matchingJobs(const Sequence& sequence, const DisparityParams& params,
                                      int frames);

}  // namespace predictive_stereo
