/// Images at half resolution.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace predictive_stereo {

/// Each pixel is the rounded mean of 2x2; an odd last row or column is left out.
void halveImage(const cv::Mat1b& image, int64_t simd_target, cv::Mat1b& half);

}  // namespace predictive_stereo
