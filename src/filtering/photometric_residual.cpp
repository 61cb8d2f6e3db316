#include "predictive_stereo/photometric_residual.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr int kWindow = 5;
constexpr int kSampleStep = 4;  ///< of the pixels that the median is taken of

struct Images {
  const cv::Mat1b &left, &right;
  const cv::Mat1f& disparity_px;
  float smallest_valid;
  double principal_offset_px;
};

cv::Vec3f differenceAt(const Images& images, int x, int y) {
  const float disparity_px = images.disparity_px(y, x);
  if (disparity_px < images.smallest_valid) return {};
  const int match = cvRound(x - disparity_px - images.principal_offset_px);
  if (match < 0 || match >= images.right.cols) return {};
  const auto difference = static_cast<float>(images.left(y, x) - images.right(y, match));
  return {1, difference, difference * difference};
}

// Sums of integers: exact, so that the order in which OpenCV adds them does not matter.
float residualOf(const cv::Vec3f& sums) {
  const double count = sums[0], sum = sums[1];
  if (count == 0) return 0;
  return static_cast<float>(std::sqrt(count * sums[2] - sum * sum) / count);
}

}  // namespace

void PhotometricResidual::measure(const cv::Mat1b& left, const cv::Mat1b& right,
                                  const cv::Mat1f& disparity_px, const DisparityRange& range,
                                  double principal_offset_px, cv::Mat1f& excess) {
  const Images images{left, right, disparity_px, static_cast<float>(range.min_disparity),
                      principal_offset_px};
  const cv::Size half((left.cols + 1) / 2, (left.rows + 1) / 2);
  differences_.create(half);
  parallelForEach(half.height, [&](int y) {
    for (int x = 0; x < half.width; ++x) differences_(y, x) = differenceAt(images, 2 * x, 2 * y);
  });
  cv::boxFilter(differences_, sums_, -1, {kWindow, kWindow}, {-1, -1}, false, cv::BORDER_CONSTANT);
  excess.create(half);
  parallelForEach(half.height, [&](int y) {
    for (int x = 0; x < half.width; ++x) excess(y, x) = residualOf(sums_(y, x));
  });
  excess -= median(excess);
}

float PhotometricResidual::median(const cv::Mat1f& residual) {
  sample_.clear();
  for (int y = 0; y < residual.rows; y += kSampleStep)
    for (int x = 0; x < residual.cols; x += kSampleStep)
      if (differences_(y, x)[0] > 0) sample_.push_back(residual(y, x));
  if (sample_.empty()) return 0;
  const auto middle = sample_.begin() + static_cast<std::ptrdiff_t>(sample_.size() / 2);
  std::nth_element(sample_.begin(), middle, sample_.end());
  return *middle;
}

}  // namespace predictive_stereo
