#include "evaluation/error_distribution.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <vector>

namespace predictive_stereo {
namespace {

double ratio(double part, int64_t whole) { return whole ? part / static_cast<double>(whole) : 0; }

}  // namespace

void ErrorHistogram::add(double error_px) {
  sum_of_all_ += error_px;
  sum_squares_of_all_ += error_px * error_px;
  if (!(std::abs(error_px) < kLimit_px)) {
    ++gross_;
    return;
  }
  const int step = static_cast<int>((error_px + kLimit_px) / kStep_px);
  ++steps_[static_cast<size_t>(std::clamp(step, 0, kSteps - 1))];
  ++inside_;
  sum_ += error_px;
  sum_squares_ += error_px * error_px;
}

ErrorHistogram& ErrorHistogram::operator+=(const ErrorHistogram& other) {
  for (size_t i = 0; i < steps_.size(); ++i) steps_[i] += other.steps_[i];
  inside_ += other.inside_;
  gross_ += other.gross_;
  sum_ += other.sum_;
  sum_squares_ += other.sum_squares_;
  sum_of_all_ += other.sum_of_all_;
  sum_squares_of_all_ += other.sum_squares_of_all_;
  return *this;
}

double ErrorHistogram::grossShare() const { return ratio(static_cast<double>(gross_), count()); }
double ErrorHistogram::mean_px() const { return ratio(sum_, inside_); }
double ErrorHistogram::variance_px2() const {
  return ratio(sum_squares_, inside_) - mean_px() * mean_px();
}

double ErrorHistogram::varianceOfAll_px2() const {
  const double mean_px = ratio(sum_of_all_, count());
  return ratio(sum_squares_of_all_, count()) - mean_px * mean_px;
}

double ErrorHistogram::quantile_px(double share) const {
  const double wanted = share * static_cast<double>(inside_);
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
  return ratio(static_cast<double>(within), count());
}

std::string ErrorHistogram::csv() const {
  std::ostringstream text;
  text << "error_px,count,share\n";
  for (int i = 0; i < kSteps; ++i) {
    const int64_t step = steps_[static_cast<size_t>(i)];
    text << -kLimit_px + kStep_px * (i + 0.5) << ',' << step << ','
         << ratio(static_cast<double>(step), count()) << '\n';
  }
  return text.str();
}

Plot ErrorHistogram::plot(const std::string& title) const {
  Plot plot;
  char figures[160];
  std::snprintf(figures, sizeof(figures), ": mean %+.3f, sigma %.3f, robust sigma %.3f px",
                mean_px(), std::sqrt(variance_px2()), robustSigma_px());
  plot.title = title + figures;
  plot.x_label = "error [px]";
  plot.y_label = "density [1/px]";
  PlotSeries measured, normal;
  measured.name = "errors";
  measured.style = "steps";
  normal.name = "normal, same variance";
  const double sigma_px = std::sqrt(std::max(1e-9, variance_px2()));
  for (int i = 0; i <= kSteps; ++i) {
    const double left_px = -kLimit_px + kStep_px * i;
    const double density =
        i < kSteps ? ratio(static_cast<double>(steps_[static_cast<size_t>(i)]), count()) / kStep_px
                   : 0.0;
    measured.points.emplace_back(left_px, density);
    const double z = (left_px - mean_px()) / sigma_px;
    normal.points.emplace_back(left_px, std::exp(-0.5 * z * z) / (sigma_px * std::sqrt(2 * M_PI)));
  }
  plot.series = {measured, normal};
  return plot;
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
