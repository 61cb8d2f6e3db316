#pragma once

#include <opencv2/imgproc.hpp>

namespace predictive_stereo {

/// An image at half resolution. Each pixel is the rounded mean of 2x2; an odd last row or column is
/// left out.
inline void halveImage(const cv::Mat1b& image, cv::Mat1b& half) {
  const cv::Size size = image.size() / 2;
  cv::resize(image(cv::Rect({0, 0}, size * 2)), half, size, 0, 0, cv::INTER_AREA);
}

}  // namespace predictive_stereo
