#include "evaluation/kitti_score_2015.h"

#include <algorithm>
#include <stdexcept>

#include "evaluation/disparity_metrics.h"

namespace predictive_stereo {
namespace {

double percent(int64_t part, int64_t whole) {
  return whole ? 100 * static_cast<double>(part) / static_cast<double>(whole) : 0;
}

/// Returns whether the row has any disparity.
bool interpolateRow(const DisparityRange& range, int width, float* row) {
  int last = -1;  // valid pixel
  for (int x = 0; x < width; ++x) {
    if (!range.isValid(row[x])) continue;
    const float fill = last < 0 ? row[x] : std::min(row[last], row[x]);
    std::fill(row + last + 1, row + x, fill);
    last = x;
  }
  if (last >= 0) std::fill(row + last + 1, row + width, row[last]);
  return last >= 0;
}

}  // namespace

void interpolateAsKitti(const DisparityRange& range, cv::Mat1f& disparity_px) {
  int filled = -1;  // the last row with disparities
  for (int y = 0; y < disparity_px.rows; ++y) {
    if (!interpolateRow(range, disparity_px.cols, disparity_px[y])) continue;
    for (int missing = filled + 1; missing < y; ++missing) {
      const bool upper = filled >= 0 && missing - filled <= y - missing;
      disparity_px.row(upper ? filled : y).copyTo(disparity_px.row(missing));
    }
    filled = y;
  }
  if (filled < 0) return;
  for (int missing = filled + 1; missing < disparity_px.rows; ++missing)
    disparity_px.row(filled).copyTo(disparity_px.row(missing));
}

double KittiCounts::d1_percent() const { return percent(interpolated_outliers, pixels); }
double KittiCounts::d1_valid_percent() const { return percent(outliers, valid); }
double KittiCounts::density_percent() const { return percent(valid, pixels); }

KittiCounts& KittiCounts::operator+=(const KittiCounts& other) {
  pixels += other.pixels;
  valid += other.valid;
  outliers += other.outliers;
  interpolated_outliers += other.interpolated_outliers;
  return *this;
}

KittiCounts KittiScore::all() const {
  KittiCounts sum = background;
  return sum += vehicles;
}

KittiScore& KittiScore::operator+=(const KittiScore& other) {
  background += other.background;
  vehicles += other.vehicles;
  return *this;
}

KittiScore scoreAsKitti(const cv::Mat1f& disparity_px, const cv::Mat1f& interpolated_px,
                        const DisparityRange& range, const cv::Mat1f& truth_px,
                        const cv::Mat1b& vehicles) {
  if (disparity_px.size() != truth_px.size() || interpolated_px.size() != truth_px.size() ||
      vehicles.size() != truth_px.size())
    throw std::invalid_argument("scoreAsKitti: disparities, truth and vehicles must have one size");
  KittiScore score;
  for (int y = 0; y < truth_px.rows; ++y)
    for (int x = 0; x < truth_px.cols; ++x) {
      const float truth = truth_px(y, x);
      if (!hasTruth(truth)) continue;
      KittiCounts& counts = vehicles(y, x) ? score.vehicles : score.background;
      ++counts.pixels;
      if (range.isValid(disparity_px(y, x))) {
        ++counts.valid;
        if (isOutlier(disparity_px(y, x), truth)) ++counts.outliers;
      }
      const float interpolated = interpolated_px(y, x);
      if (!range.isValid(interpolated) || isOutlier(interpolated, truth))
        ++counts.interpolated_outliers;
    }
  return score;
}

}  // namespace predictive_stereo
