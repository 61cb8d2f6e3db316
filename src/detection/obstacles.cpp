#include "detection/obstacles.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

namespace predictive_stereo {
namespace {

// Largest step within a surface: the largest of these. The last one counts standard deviations of
// the difference of two disparities.
constexpr float kStep_m = 0.3f, kStep_px = 1, kStepSigmas = 1;
constexpr float kFarthest_m = 60;
constexpr float kWide_px = 1e6f;

// Sets of cells; the root of a set is its first cell.
class JoinedCells {
 public:
  explicit JoinedCells(int count) : parent_(static_cast<size_t>(count)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int rootOf(int i) {
    while (at(i) != i) i = at(i) = at(at(i));  // halves the path for the next call
    return i;
  }
  void join(int i, int j) {
    i = rootOf(i);
    j = rootOf(j);
    at(std::max(i, j)) = std::min(i, j);
  }

 private:
  int& at(int i) { return parent_[static_cast<size_t>(i)]; }
  std::vector<int> parent_;
};

// Cells that can belong to obstacles.
cv::Mat1b usableCells(const StereoRig& rig, const DepthCells& cells,
                      const std::optional<GroundPlane>& ground) {
  const auto least_px = static_cast<float>(rig.disparityTimesDepth() / kFarthest_m);
  cv::Mat1b usable(cells.disparity_px.size());
  for (int v = 0; v < usable.rows; ++v)
    for (int u = 0; u < usable.cols; ++u) {
      const float d = cells.disparity_px(v, u);
      usable(v, u) =
          d > 0 && d >= least_px && (!ground || ground->heightOf({u, v}, d) > kGroundMargin_m);
    }
  return usable;
}

JoinedCells joinSurfaces(const StereoRig& rig, const DepthCells& cells, const cv::Mat1b& usable) {
  const int columns = usable.cols;
  const auto step_per_px2 = kStep_m / static_cast<float>(rig.disparityTimesDepth());
  JoinedCells joined(usable.rows * columns);
  const auto joinIfLevel = [&](int u, int v, int s, int t) {
    if (s < 0 || s >= columns || t >= usable.rows || !usable(t, s)) return;
    const float d = cells.disparity_px(v, u), e = cells.disparity_px(t, s);
    const float larger = std::max(d, e);
    const float sigma_px = std::sqrt(cells.variance_px2(v, u) + cells.variance_px2(t, s));
    if (std::abs(d - e) <=
        std::max({kStep_px, step_per_px2 * larger * larger, kStepSigmas * sigma_px}))
      joined.join(v * columns + u, t * columns + s);
  };
  for (int v = 0; v < usable.rows; ++v)
    for (int u = 0; u < columns; ++u) {
      if (!usable(v, u)) continue;
      joinIfLevel(u, v, u + 1, v);
      for (int s = u - 1; s <= u + 1; ++s) joinIfLevel(u, v, s, v + 1);
      if (u + 1 < columns && !usable(v, u + 1)) joinIfLevel(u, v, u + 2, v);
      if (v + 1 < usable.rows && !usable(v + 1, u)) joinIfLevel(u, v, u, v + 2);
    }
  return joined;
}

}  // namespace

std::vector<Obstacle> findObstacles(const StereoRig& rig, const DepthCells& cells,
                                    const std::optional<GroundPlane>& ground) {
  const cv::Mat1b usable = usableCells(rig, cells, ground);
  JoinedCells joined = joinSurfaces(rig, cells, usable);
  std::vector<int> number_of_root(usable.total(), -1);
  std::vector<Obstacle> obstacles;
  for (int v = 0; v < usable.rows; ++v)
    for (int u = 0; u < usable.cols; ++u) {
      if (!usable(v, u)) continue;
      int& number = number_of_root[static_cast<size_t>(joined.rootOf(v * usable.cols + u))];
      if (number < 0) {
        number = static_cast<int>(obstacles.size());
        obstacles.emplace_back();
      }
      Obstacle& obstacle = obstacles[static_cast<size_t>(number)];
      obstacle.cells.emplace_back(u, v);
      obstacle.area |= cv::Rect(u, v, 1, 1);
    }
  return obstacles;
}

cv::Mat1f obstacleWidths(const std::vector<Obstacle>& obstacles, const DepthCells& cells) {
  const cv::Mat1f& disparity = cells.disparity_px;
  cv::Mat1i number(disparity.size(), 0);
  int last = 0;
  for (const Obstacle& obstacle : obstacles) {
    ++last;
    for (const cv::Point p : obstacle.cells) number(p) = last;
  }
  cv::Mat1b inner(disparity.size(), uchar(0));
  for (int v = 0; v < number.rows; ++v)
    for (int u = 0; u < number.cols; ++u) {
      bool at_end = number(v, u) == 0;
      for (int t = std::max(v - 1, 0); t <= std::min(v + 1, number.rows - 1); ++t)
        for (int s = std::max(u - 1, 0); s <= std::min(u + 1, number.cols - 1); ++s)
          at_end |= number(t, s) != number(v, u) && disparity(t, s) < disparity(v, u);
      inner(v, u) = at_end ? 0 : 255;
    }
  cv::Mat1f from_end, width_px(disparity.size(), kWide_px);
  cv::distanceTransform(inner, from_end, cv::DIST_C, 3);
  for (const Obstacle& obstacle : obstacles) {
    float most = 0;
    for (const cv::Point p : obstacle.cells) most = std::max(most, from_end(p));
    for (const cv::Point p : obstacle.cells) width_px(p) = kCellSide_px * (2 * most + 1);
  }
  return width_px;
}

}  // namespace predictive_stereo
