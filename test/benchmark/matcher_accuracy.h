/// Accuracy of OpenCV's matchers and ours on single frames.
#pragma once

#include <vector>

#include "benchmark/matching_jobs.h"

namespace predictive_stereo {

/// Prints a table of density, outliers and mean search width over the frames with truth; nothing if
/// there are none. Our matchers include the post-filters of DisparityLoop: support, holes,
/// median.
void printMatcherAccuracy(const std::vector<MatchingJob>& jobs, const DisparityParams& params);

}  // namespace predictive_stereo
