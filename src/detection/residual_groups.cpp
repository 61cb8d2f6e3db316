#include "detection/residual_groups.h"

#include <algorithm>
#include <cmath>

#include "detection/long_residual.h"
#include "detection/residual_group_rows.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr int kFewestKnown = 15;    // of a window's 25 points
constexpr float kLeastSign = 0.8f;  // 90 % of one sign, 10 % of the other
constexpr int kFewestPoints = 20;   // of a group

float medianOf(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The first seed of a row from column u on; `columns` if there is none. Most points are not seeds.
int nextSeed(const uchar* seeds, int u, int columns) {
  constexpr int kBlock = 32;
  const auto isSeed = [](uchar kind) { return kind != kNoSeed; };
  while (u + kBlock <= columns) {
    int any = 0;
    for (int i = 0; i < kBlock; ++i) any |= seeds[u + i];
    if (any != 0) break;
    u += kBlock;
  }
  return static_cast<int>(std::find_if(seeds + u, seeds + columns, isSeed) - seeds);
}

}  // namespace

const std::vector<ResidualGroup>& ResidualGroups::find(const cv::Mat1f& residual_px,
                                                       const cv::Mat1b& pair,
                                                       const cv::Mat1f& disparity_px,
                                                       const MotionDetectionParams& params) {
  const SeedLimits limits{kUnknownResidual, kFewestKnown,
                          static_cast<float>(params.dense_min_residual_px), kLeastSign};
  seeds_.create(residual_px.size());
  seeds_of_row_.resize(static_cast<size_t>(residual_px.rows));
  parallelFor(cv::Range(0, residual_px.rows), [&](const cv::Range& range) {
    for (int v = range.start; v < range.end; ++v) {
      int& count = seeds_of_row_[static_cast<size_t>(v)];
      const bool within = v >= kResidualReach && v < residual_px.rows - kResidualReach;
      if (!within || residual_px.cols < kResidualSide) {
        count = 0;
        std::fill_n(seeds_[v], seeds_.cols, uchar{kNoSeed});
        continue;
      }
      const float* rows[kResidualSide];
      for (int k = 0; k < kResidualSide; ++k) rows[k] = residual_px[v + k - kResidualReach];
      count = seedRow(rows, pair[v], residual_px.cols, limits, seeds_[v]);
    }
  });
  return connect(disparity_px);
}

const std::vector<ResidualGroup>& ResidualGroups::connect(const cv::Mat1f& disparity_px) {
  // Flood fill over neighbours with the same sign and a similar disparity.
  cv::Mat1b& seeds = seeds_;
  std::vector<cv::Point>& open = open_;
  groups_.clear();
  for (int v = 0; v < seeds.rows; ++v) {
    if (seeds_of_row_[static_cast<size_t>(v)] == 0) continue;
    for (int u = nextSeed(seeds[v], 0, seeds.cols); u < seeds.cols;
         u = nextSeed(seeds[v], u, seeds.cols)) {
      const uchar kind = seeds(v, u);
      ResidualGroup group;
      seeds(v, u) = kNoSeed;
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
          seeds(q) = kNoSeed;
          open.push_back(q);
        }
      }
      if (static_cast<int>(group.points.size()) < kFewestPoints) continue;
      std::vector<float> disparities;
      for (cv::Point p : group.points) disparities.push_back(disparity_px(2 * p.y, 2 * p.x));
      group.disparity_px = medianOf(disparities);
      groups_.push_back(std::move(group));
    }
  }
  std::stable_sort(groups_.begin(), groups_.end(),
                   [](const ResidualGroup& a, const ResidualGroup& b) {
                     return a.points.size() > b.points.size();
                   });
  return groups_;
}

}  // namespace predictive_stereo
