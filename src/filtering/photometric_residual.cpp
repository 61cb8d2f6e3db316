#include "predictive_stereo/photometric_residual.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr int kWindow = 5;
constexpr int kSampleStep = 2;  ///< of the residuals that the median is taken of

struct Images {
  const cv::Mat1b &left, &right;
  const cv::Mat1f& disparity_px;
  float smallest_valid;
  double principal_offset_px;
};

cv::Vec<int, 5> sumsOf(const Images& images, int x, int y) {
  const float disparity_px = images.disparity_px(y, x);
  if (disparity_px < images.smallest_valid) return {};
  const int match = cvRound(x - disparity_px - images.principal_offset_px);
  if (match < 0 || match >= images.right.cols) return {};
  const int left = images.left(y, x), difference = left - images.right(y, match);
  return {1, difference, difference * difference, left, left * left};
}

float deviation(double count, double sum, double squares) {
  return count == 0 ? 0.0f : static_cast<float>(std::sqrt(count * squares - sum * sum) / count);
}

}  // namespace

void PhotometricResidual::measure(const cv::Mat1b& left, const cv::Mat1b& right,
                                  const cv::Mat1f& disparity_px, const DisparityRange& range,
                                  double principal_offset_px, cv::Mat1f& share) {
  const Images images{left, right, disparity_px, static_cast<float>(range.min_disparity),
                      principal_offset_px};
  pixels_.create((left.rows + kResidualStep - 1) / kResidualStep,
                 (left.cols + kResidualStep - 1) / kResidualStep);
  parallelForEach(pixels_.rows, [&](int y) {
    for (int x = 0; x < pixels_.cols; ++x)
      pixels_(y, x) = sumsOf(images, kResidualStep * x, kResidualStep * y);
  });
  cv::boxFilter(pixels_, windows_, -1, {kWindow, kWindow}, {-1, -1}, false, cv::BORDER_CONSTANT);

  share.create(pixels_.size());
  parallelForEach(share.rows, [&](int y) {
    for (int x = 0; x < share.cols; ++x) {
      const Sums& sums = windows_(y, x);
      share(y, x) = deviation(sums[0], sums[1], sums[2]);
    }
  });
  const float usual = medianResidual(share);
  parallelForEach(share.rows, [&](int y) {
    for (int x = 0; x < share.cols; ++x) {
      const Sums& sums = windows_(y, x);
      const float above = share(y, x) - usual;
      share(y, x) =
          above > 0 ? std::min(above / (deviation(sums[0], sums[3], sums[4]) + 1), 1.0f) : 0;
    }
  });
}

float PhotometricResidual::medianResidual(const cv::Mat1f& residual) {
  sample_.clear();
  for (int y = 0; y < residual.rows; y += kSampleStep)
    for (int x = 0; x < residual.cols; x += kSampleStep)
      if (pixels_(y, x)[0] > 0) sample_.push_back(residual(y, x));
  if (sample_.empty()) return 0;
  const auto middle = sample_.begin() + static_cast<std::ptrdiff_t>(sample_.size() / 2);
  std::nth_element(sample_.begin(), middle, sample_.end());
  return *middle;
}

}  // namespace predictive_stereo
