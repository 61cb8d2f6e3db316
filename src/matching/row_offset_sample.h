#pragma once

#include <opencv2/core.hpp>

namespace predictive_stereo {

/// Measures the row offset of a patch, from the left image to the right one (positive: down), with
/// sub-pixel accuracy by the zero-mean sum of squared differences.
/// @param centre  of the patch, in the left image.
/// @param disparity_px  correct to about a pixel.
/// @returns false if the patch leaves an image, has too little vertical texture, or is not unique;
///   `offset_px` is then unchanged.
bool measureRowOffset(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point centre,
                      int disparity_px, double& offset_px);

}  // namespace predictive_stereo
