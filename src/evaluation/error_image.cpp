#include "evaluation/error_image.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace predictive_stereo {

ErrorImage::ErrorImage(cv::Size size)
    : size_(size),
      sums_px_((size.height + kCell_px - 1) / kCell_px, (size.width + kCell_px - 1) / kCell_px,
               0.0) {}

void ErrorImage::add(double x_px, double y_px, double error_px) {
  const cv::Point pixel(static_cast<int>(std::lround(x_px)), static_cast<int>(std::lround(y_px)));
  if (cv::Rect(cv::Point(), size_).contains(pixel))
    sums_px_(pixel / kCell_px) += std::abs(error_px);
}

cv::Mat3b ErrorImage::picture() const {
  std::vector<double> sums;
  for (const double sum : sums_px_)
    if (sum > 0) sums.push_back(sum);
  double most = 1;
  if (!sums.empty()) {
    const auto percentile = sums.begin() + static_cast<std::ptrdiff_t>(sums.size() * 99 / 100);
    std::nth_element(sums.begin(), percentile, sums.end());
    most = *percentile;
  }
  cv::Mat3b image(size_, cv::Vec3b(255, 255, 255));
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const auto rest = cv::saturate_cast<uchar>(255 * (1 - sum_px(x, y) / most));
      image(y, x) = {255, rest, rest};
    }
  return image;
}

}  // namespace predictive_stereo
