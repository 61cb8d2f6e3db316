/// Scaling of the times of full and reduced search.
#pragma once

#include "benchmark/matching_jobs.h"

namespace predictive_stereo {

/// Prints times by image area, disparities, width of the ranges, threads and SIMD target.
void printMatcherGrowth(const MatchingJob& job, const MatcherParams& params, int rounds);

}  // namespace predictive_stereo
