#include "odometry/row_offset.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace predictive_stereo {
namespace {

using Terms = Eigen::Matrix<double, 6, 1>;

// The model of RowAlignment.
Terms terms(cv::Point2f position, cv::Size size) {
  const double u = 2.0 * position.x / size.width - 1, v = 2.0 * position.y / size.height - 1;
  Terms t;
  t << 1, u, v, u * u, u * v, v * v;
  return t;
}

}  // namespace

float rowOffset(const RowAlignment& alignment, cv::Point2f position, cv::Size size) {
  return static_cast<float>(terms(position, size).dot(alignment.coefficients_px));
}

RowAlignment fitRowOffset(const std::vector<RowOffsetSample>& samples, cv::Size size,
                          const RowAlignment& past, const RowAlignmentParams& params) {
  const auto enough = static_cast<size_t>(params.min_samples);
  if (samples.size() < enough) return past;

  RowAlignment fit = past;
  std::vector<double> residuals(samples.size());
  for (size_t i = 0; i < samples.size(); ++i) residuals[i] = samples[i].offset_px;
  if (past.isIdentity()) {
    const auto middle = residuals.begin() + residuals.size() / 2;
    std::nth_element(residuals.begin(), middle, residuals.end());
    fit.coefficients_px.setZero();
    fit.coefficients_px[0] = *middle;
  }
  double sum = 0;
  for (const double gate_px : {2.0, 1.0, 0.7, 0.5, 0.5}) {
    // A weak pull to the past keeps corners of the image without samples where they were.
    Matrix6d A = Matrix6d::Identity() * 0.5;
    Terms b = 0.5 * fit.coefficients_px;
    sum = 0;
    fit.samples = 0;
    for (const RowOffsetSample& sample : samples) {
      const Terms t = terms(sample.position, size);
      const double residual = sample.offset_px - t.dot(fit.coefficients_px);
      if (std::abs(residual) > gate_px) continue;
      const double weight = 1 / (1 + residual * residual / (0.2 * 0.2));
      A += weight * t * t.transpose();
      b += weight * sample.offset_px * t;
      sum += residual * residual;
      ++fit.samples;
    }
    if (fit.samples < params.min_samples) return past;
    fit.coefficients_px = A.ldlt().solve(b);
  }
  fit.residual_px = std::sqrt(sum / fit.samples);
  if (!past.isIdentity())
    fit.coefficients_px += params.smoothing * (past.coefficients_px - fit.coefficients_px);
  fit.largest_offset_px = 0;
  for (int y = 0; y <= 8; ++y)
    for (int x = 0; x <= 8; ++x) {
      const cv::Point2f at(size.width * x / 8.f, size.height * y / 8.f);
      fit.largest_offset_px =
          std::max(fit.largest_offset_px, std::abs(terms(at, size).dot(fit.coefficients_px)));
    }
  return fit.largest_offset_px > params.max_offset_px ? past : fit;
}

}  // namespace predictive_stereo
