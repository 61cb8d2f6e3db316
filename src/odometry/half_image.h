#pragma once

#include <opencv2/core.hpp>

namespace predictive_stereo {

/// An image of half the size, rounded up, smoothed by (1 4 6 4 1) / 16 both ways, with mirrored
/// borders: cv::pyrDown, for a quarter of its instructions. The memory of `half` is reused.
void halve(const cv::Mat1b& image, cv::Mat1b& half);

}  // namespace predictive_stereo
