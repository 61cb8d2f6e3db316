/// How good OpenCV's matchers and ours are on single frames.
#pragma once

#include <vector>

#include "benchmark/matching_jobs.h"

namespace predictive_stereo {

/// A table of density, outliers and mean width over the frames with truth; nothing where there are
/// none. Ours with the post-filters of DisparityEstimator: support, holes, median.
void printMatcherAccuracy(const std::vector<MatchingJob>& jobs, const DisparityParams& params);

}  // namespace predictive_stereo
