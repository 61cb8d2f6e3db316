#include "evaluation/error_distribution.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "evaluation/report.h"

namespace predictive_stereo {

void ErrorHistogram::add(double error_px) {
  all_.add(error_px);
  if (!(std::abs(error_px) < kLimit_px)) return;
  const int step = static_cast<int>((error_px + kLimit_px) / kStep_px);
  ++steps_[static_cast<size_t>(std::clamp(step, 0, kSteps - 1))];
  inside_.add(error_px);
}

ErrorHistogram& ErrorHistogram::operator+=(const ErrorHistogram& other) {
  for (size_t i = 0; i < steps_.size(); ++i) steps_[i] += other.steps_[i];
  inside_ += other.inside_;
  all_ += other.all_;
  return *this;
}

double ErrorHistogram::quantile_px(double share) const {
  const double wanted = share * static_cast<double>(inside_.count());
  double below = 0;
  for (int i = 0; i < kSteps; ++i) {
    const auto inside = static_cast<double>(steps_[static_cast<size_t>(i)]);
    if (below + inside >= wanted && inside > 0)
      return -kLimit_px + kStep_px * (i + (wanted - below) / inside);
    below += inside;
  }
  return kLimit_px;
}

double ErrorHistogram::robustSigma_px() const {
  return (quantile_px(0.8413) - quantile_px(0.1587)) / 2;
}

double ErrorHistogram::shareWithin(double limit_px) const {
  int64_t within = 0;
  for (int i = 0; i < kSteps; ++i)
    if (std::abs(-kLimit_px + kStep_px * (i + 0.5)) < limit_px)
      within += steps_[static_cast<size_t>(i)];
  return ratio(within, count());
}

std::string ErrorHistogram::csv() const {
  Table csv = Table::ofCsv("error_px,count,share");
  for (int i = 0; i < kSteps; ++i) {
    const int64_t step = steps_[static_cast<size_t>(i)];
    csv.add(-kLimit_px + kStep_px * (i + 0.5), step, ratio(step, count()));
  }
  return csv.csv();
}

ErrorImage::ErrorImage(cv::Size size)
    : size_(size),
      sums_px_((size.height + kCell_px - 1) / kCell_px, (size.width + kCell_px - 1) / kCell_px,
               0.0) {}

void ErrorImage::add(double x_px, double y_px, double error_px) {
  const cv::Point pixel(static_cast<int>(std::lround(x_px)), static_cast<int>(std::lround(y_px)));
  if (cv::Rect(cv::Point(), size_).contains(pixel))
    sums_px_(pixel / kCell_px) += std::abs(error_px);
}

cv::Mat1w ErrorImage::map() const {
  double most_px = 0;
  cv::minMaxLoc(sums_px_, nullptr, &most_px);
  cv::Mat1w levels;
  sums_px_.convertTo(levels, CV_16U, most_px > 0 ? 65535 / most_px : 0);
  cv::resize(levels, levels, {}, kCell_px, kCell_px, cv::INTER_NEAREST);
  return levels(cv::Rect({}, size_)).clone();
}

}  // namespace predictive_stereo
