#include "detection/residual_groups.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "detection/long_residual.h"

namespace predictive_stereo {
namespace {

constexpr int kSide = 5;            // of the squares over which residuals are summed
constexpr float kFewestKnown = 15;  // points of a square
constexpr float kLeastSign = 0.8f;  // 90 % of one sign, 10 % of the other
constexpr size_t kFewestPoints = 20;
constexpr float kMostStep_px = 1.5f;  // of the disparity, between neighbours

cv::Mat1f sumsOfSquares(const cv::Mat1f& map) {
  cv::Mat1f sums;
  cv::boxFilter(map, sums, CV_32F, {kSide, kSide}, {-1, -1}, false, cv::BORDER_CONSTANT);
  return sums;
}

constexpr uchar kNoSeed = 0;

// Points in whose square residuals are large and of one sign. Seeds of one value have the same pair
// and sign.
cv::Mat1b findSeeds(const cv::Mat1f& residual_px, const cv::Mat1b& pair, float least_mean_px) {
  cv::Mat1f known(residual_px.size()), usable(residual_px.size()), sign(residual_px.size());
  for (int v = 0; v < residual_px.rows; ++v)
    for (int u = 0; u < residual_px.cols; ++u) {
      const float r = residual_px(v, u);
      known(v, u) = r != kUnknownResidual ? 1.0f : 0.0f;
      usable(v, u) = r != kUnknownResidual ? r : 0.0f;
      sign(v, u) = static_cast<float>((usable(v, u) > 0) - (usable(v, u) < 0));
    }
  const cv::Mat1f count = sumsOfSquares(known), sum = sumsOfSquares(usable),
                  signs = sumsOfSquares(sign);
  cv::Mat1b seeds(residual_px.size());
  for (int v = 0; v < seeds.rows; ++v)
    for (int u = 0; u < seeds.cols; ++u) {
      const bool is_seed = count(v, u) >= kFewestKnown &&
                           std::abs(usable(v, u)) >= 0.5f * least_mean_px &&
                           std::abs(sum(v, u)) >= least_mean_px * count(v, u) &&
                           std::abs(signs(v, u)) >= kLeastSign * count(v, u);
      seeds(v, u) =
          is_seed ? static_cast<uchar>(2 * pair(v, u) + (sum(v, u) > 0 ? 1 : 2)) : kNoSeed;
    }
  return seeds;
}

float medianDisparity(const cv::Mat1f& disparity_px, const std::vector<cv::Point>& points) {
  std::vector<float> values;
  for (const cv::Point p : points) values.push_back(disparity_px(2 * p));
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The seeds that are connected to the first one, which are then none any more.
std::vector<cv::Point> takeConnected(const cv::Mat1f& disparity_px, cv::Point first,
                                     cv::Mat1b& seeds) {
  const uchar kind = seeds(first);
  std::vector<cv::Point> open{first}, points;
  seeds(first) = kNoSeed;
  while (!open.empty()) {
    const cv::Point p = open.back();
    open.pop_back();
    points.push_back(p);
    const float d = disparity_px(2 * p);
    for (const cv::Point step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const cv::Point q = p + step;
      if (!cv::Rect(cv::Point(), seeds.size()).contains(q) || seeds(q) != kind ||
          std::abs(disparity_px(2 * q) - d) > kMostStep_px)
        continue;
      seeds(q) = kNoSeed;
      open.push_back(q);
    }
  }
  return points;
}

}  // namespace

std::vector<ResidualGroup> groupResiduals(const cv::Mat1f& residual_px, const cv::Mat1b& pair,
                                          const cv::Mat1f& disparity_px, float least_mean_px) {
  cv::Mat1b seeds = findSeeds(residual_px, pair, least_mean_px);
  std::vector<ResidualGroup> groups;
  for (int v = 0; v < seeds.rows; ++v)
    for (int u = 0; u < seeds.cols; ++u) {
      if (seeds(v, u) == kNoSeed) continue;
      std::vector<cv::Point> points = takeConnected(disparity_px, {u, v}, seeds);
      if (points.size() < kFewestPoints) continue;
      const float median_px = medianDisparity(disparity_px, points);
      groups.push_back({std::move(points), median_px});
    }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const ResidualGroup& a, const ResidualGroup& b) {
                     return a.points.size() > b.points.size();
                   });
  return groups;
}

}  // namespace predictive_stereo
