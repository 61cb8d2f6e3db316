#include "evaluation/disparity_metrics.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace predictive_stereo {
namespace {

// Mean over n of the mean of the first n values, for n = 1 ... size.
double areaUnder(const std::vector<double>& values) {
  double sum = 0, area = 0;
  for (size_t n = 0; n < values.size(); ++n) {
    sum += values[n];
    area += sum / static_cast<double>(n + 1);
  }
  return values.empty() ? 0 : area / static_cast<double>(values.size());
}

}  // namespace

bool isOutlier(float disparity_px, float truth_px) {
  const float error_px = std::abs(disparity_px - truth_px);
  return error_px > 3.0f && error_px > 0.05f * truth_px;
}

double DisparityScore::density_percent() const { return 100 * ratio(valid_pixels, truth_pixels); }
double DisparityScore::d1_percent() const { return 100 * ratio(outliers, valid_pixels); }
double DisparityScore::d1_filled_percent() const { return 100 * ratio(wrong(), truth_pixels); }
double DisparityScore::rms_px() const {
  return std::sqrt(ratio(sum_squared_inlier_error_px2, valid_pixels - outliers));
}

DisparityScore& DisparityScore::operator+=(const DisparityScore& other) {
  truth_pixels += other.truth_pixels;
  valid_pixels += other.valid_pixels;
  outliers += other.outliers;
  sum_squared_inlier_error_px2 += other.sum_squared_inlier_error_px2;
  return *this;
}

DisparityScore scoreDisparity(const cv::Mat1f& disparity_px, const DisparityRange& range,
                              const cv::Mat1f& truth_px, const cv::Mat1b& mask) {
  if (disparity_px.size() != truth_px.size() || (!mask.empty() && mask.size() != truth_px.size()))
    throw std::invalid_argument("scoreDisparity: disparity, truth and mask must have one size");
  DisparityScore score;
  for (int y = 0; y < truth_px.rows; ++y)
    for (int x = 0; x < truth_px.cols; ++x) {
      const float truth = truth_px(y, x);
      if (!hasTruth(truth) || (!mask.empty() && mask(y, x) == 0)) continue;
      ++score.truth_pixels;
      const float disparity = disparity_px(y, x);
      if (!range.isValid(disparity)) continue;
      ++score.valid_pixels;
      if (isOutlier(disparity, truth)) {
        ++score.outliers;
        continue;
      }
      const double error_px = static_cast<double>(disparity) - truth;
      score.sum_squared_inlier_error_px2 += error_px * error_px;
    }
  return score;
}

void MeanDisparityScore::add(const DisparityScore& score) {
  if (score.truth_pixels == 0) return;
  updateMean(density_percent, score.density_percent(), frames);
  updateMean(d1_filled_percent, score.d1_filled_percent(), frames);
  ++frames;
  if (score.valid_pixels == 0) return;
  updateMean(d1_percent, score.d1_percent(), frames_with_valid_);
  updateMean(rms_px, score.rms_px(), frames_with_valid_);
  ++frames_with_valid_;
}

void VarianceCalibration::add(double error_px, double variance_px2) {
  if (!(variance_px2 > 0))
    throw std::invalid_argument("VarianceCalibration: variance = " + std::to_string(variance_px2) +
                                " px^2: must be positive");
  const double sigma_px = std::sqrt(variance_px2);
  const double bin = std::abs(error_px) / sigma_px / kBinWidth;
  ++histogram_[static_cast<size_t>(std::min(bin, kBins - 1.0))];
  sigmas_px_.add(sigma_px);
  sum_nll_ += 0.5 * (std::log(2 * M_PI * variance_px2) + error_px * error_px / variance_px2);
}

double VarianceCalibration::shareWithin(double sigmas) const {
  const int bins = std::min(kBins, static_cast<int>(std::ceil(sigmas / kBinWidth - 1e-9)));
  int64_t within = 0;
  for (int i = 0; i < bins; ++i) within += histogram_[static_cast<size_t>(i)];
  return ratio(within, count());
}

void Sparsification::add(double error_px, double doubt) {
  pixels_.push_back({static_cast<float>(doubt), static_cast<float>(std::abs(error_px))});
}

double Sparsification::meanError_px() const {
  double sum = 0;
  for (const Pixel& pixel : pixels_) sum += pixel.error_px;
  return pixels_.empty() ? 0 : sum / static_cast<double>(pixels_.size());
}

double Sparsification::ause_px() const {
  std::vector<Pixel> sorted = pixels_;
  std::sort(sorted.begin(), sorted.end(),
            [](const Pixel& a, const Pixel& b) { return a.doubt < b.doubt; });
  std::vector<double> errors_px;
  for (auto begin = sorted.begin(); begin != sorted.end();) {
    const auto end = std::find_if(begin, sorted.end(),
                                  [&](const Pixel& pixel) { return pixel.doubt > begin->doubt; });
    double sum = 0;
    for (auto pixel = begin; pixel != end; ++pixel) sum += pixel->error_px;
    errors_px.insert(errors_px.end(), static_cast<size_t>(end - begin),
                     sum / static_cast<double>(end - begin));
    begin = end;
  }
  return areaUnder(errors_px) - meanError_px() + auseOfNothing_px();
}

double Sparsification::auseOfNothing_px() const {
  std::vector<double> errors_px;
  for (const Pixel& pixel : pixels_) errors_px.push_back(pixel.error_px);
  std::sort(errors_px.begin(), errors_px.end());
  return meanError_px() - areaUnder(errors_px);
}

}  // namespace predictive_stereo
