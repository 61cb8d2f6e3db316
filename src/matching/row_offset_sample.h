#pragma once

#include <opencv2/core.hpp>

namespace predictive_stereo {

/// Measures how many rows below its place in the left image a patch lies in the right one, to a
/// fraction of a pixel, by the zero-mean sum of squared differences.
/// @param centre  of the patch, in the left image.
/// @param disparity_px  good to about a pixel.
/// @return false where the patch leaves an image, shows too little texture across rows, or fits in
///   more than one place; `offset_px` is then left as it was.
bool measureRowOffset(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point centre,
                      int disparity_px, double& offset_px);

}  // namespace predictive_stereo
