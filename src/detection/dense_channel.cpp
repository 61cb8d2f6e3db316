#include "detection/dense_channel.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace predictive_stereo {
namespace {

constexpr int kWindow = 7;
constexpr float kFewestKnown = 0.6f * kWindow * kWindow;
constexpr float kLargestPx = 8.0f;
constexpr int kFewestPoints = 20;  // of a group

void boxSum(const cv::Mat1f& in, cv::Mat1f& out) {
  cv::boxFilter(in, out, CV_32F, {kWindow, kWindow}, {-1, -1}, false, cv::BORDER_CONSTANT);
}

float medianOf(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void denseResidual(const DetectionInput& input, const DisparityRange& range,
                   const SourceOf& static_source, const cv::Mat1f& previous_disparity_px,
                   cv::Size lattice, cv::Mat1f& residual_px) {
  residual_px.create(lattice);
  // Near discontinuities the prediction's variance is that of no prediction.
  const auto count = static_cast<float>(range.count);
  const DenseLimits limits{static_cast<float>(range.min_disparity), 0.5f * count * count / 12,
                           kLargestPx, kUnknownResidual};
  const cv::Mat1f& before = previous_disparity_px;
  cv::parallel_for_(cv::Range(0, lattice.height), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v)
      residualRow(latticeRow(static_source, input.measured_disparity_px, range, lattice,
                             cv::Rect(cv::Point(), lattice), v),
                  input.predicted_disparity_px[2 * v], input.predicted_variance_px2[2 * v],
                  before[0], static_cast<int>(before.step1()), before.cols, before.rows, limits,
                  residual_px[v]);
  });
}

std::vector<DenseGroup> denseGroups(const cv::Mat1f& residual_px, const cv::Mat1f& disparity_px,
                                    const MotionDetectionParams& params) {
  cv::Mat1f value(residual_px.size()), known(residual_px.size()), sign(residual_px.size());
  cv::parallel_for_(cv::Range(0, value.rows), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v)
      for (int u = 0; u < value.cols; ++u) {
        const float r = residual_px(v, u);
        const float is_known = r != kUnknownResidual ? 1.0f : 0.0f;
        value(v, u) = r != kUnknownResidual ? r : 0.0f;
        known(v, u) = is_known;
        sign(v, u) = is_known * static_cast<float>((r > 0) - (r < 0));
      }
  });
  cv::Mat1f value_sum, known_sum, sign_sum;
  boxSum(value, value_sum);
  boxSum(known, known_sum);
  boxSum(sign, sign_sum);
  const auto least = static_cast<float>(params.dense_min_residual_px);
  // 90 % of one sign, the rest of the other one: a sum of 0.8.
  const auto least_sign = static_cast<float>(2 * params.dense_one_sign - 1);
  cv::Mat1b seeds(value.size());
  cv::parallel_for_(cv::Range(0, value.rows), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v)
      for (int u = 0; u < value.cols; ++u) {
        const float n = known_sum(v, u), s = value_sum(v, u);
        const bool seed = n >= kFewestKnown && std::abs(s) >= least * n &&
                          std::abs(sign_sum(v, u)) >= least_sign * n && known(v, u) > 0;
        seeds(v, u) = seed ? (s > 0 ? 1 : 2) : 0;
      }
  });
  // Flood over neighbours of one sign and similar disparity.
  std::vector<DenseGroup> groups;
  std::vector<cv::Point> open;
  for (int v = 0; v < seeds.rows; ++v)
    for (int u = 0; u < seeds.cols; ++u) {
      if (!seeds(v, u)) continue;
      const uchar kind = seeds(v, u);
      DenseGroup group;
      seeds(v, u) = 0;
      open.assign(1, {u, v});
      while (!open.empty()) {
        const cv::Point p = open.back();
        open.pop_back();
        group.points.push_back(p);
        const float d = disparity_px(2 * p.y, 2 * p.x);
        for (const cv::Point step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
          const cv::Point q = p + step;
          if (q.x < 0 || q.y < 0 || q.x >= seeds.cols || q.y >= seeds.rows || seeds(q) != kind)
            continue;
          if (std::abs(disparity_px(2 * q.y, 2 * q.x) - d) > 1.5f) continue;
          seeds(q) = 0;
          open.push_back(q);
        }
      }
      if (static_cast<int>(group.points.size()) < kFewestPoints) continue;
      std::vector<float> disparities, residuals;
      for (cv::Point p : group.points) {
        disparities.push_back(disparity_px(2 * p.y, 2 * p.x));
        residuals.push_back(residual_px(p));
      }
      group.disparity_px = medianOf(disparities);
      group.residual_px = medianOf(residuals);
      groups.push_back(std::move(group));
    }
  std::stable_sort(groups.begin(), groups.end(), [](const DenseGroup& a, const DenseGroup& b) {
    return a.points.size() > b.points.size();
  });
  return groups;
}

}  // namespace predictive_stereo
