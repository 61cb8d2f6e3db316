#include "detection/obstacles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace predictive_stereo {
namespace {

// Largest step within a surface: the larger of these.
constexpr float kStep_m = 0.3f, kStep_px = 1;
// Standard deviations of a step that have to be within it, too. Otherwise noise, as on a floor
// without texture, joins all that touches it.
constexpr float kSigmas = 2;
constexpr float kFarthest_m = 60;
constexpr float kWide_px = 1e6f;

// Sets of cells; the root of a set is its first cell. Cells are added row by row.
class JoinedCells {
 public:
  explicit JoinedCells(int count) : parent_(static_cast<size_t>(count)) {}
  void add(int i) { at(i) = i; }
  int rootOf(int i) {
    while (at(i) != i) i = at(i) = at(at(i));  // halves the path for the next call
    return i;
  }
  /// May miss that they are.
  bool areJoined(int i, int j) { return at(i) == at(j); }
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
  const float least_px = std::max(static_cast<float>(rig.disparityTimesDepth() / kFarthest_m),
                                  std::numeric_limits<float>::denorm_min());
  // Its height is h (1 - expected / d): see GroundPlane::heightOf.
  const auto h = ground ? static_cast<float>(ground->camera_height_m) : 0.0f;
  const auto per_column_px = ground ? static_cast<float>(kCellSide_px * ground->a) : 0.0f;
  const auto margin_m = ground ? static_cast<float>(kGroundMargin_m) : -1.0f;
  cv::Mat1b usable(cells.disparity_px.size());
  for (int v = 0; v < usable.rows; ++v) {
    const float* const disparity = cells.disparity_px[v];
    uchar* const of_row = usable[v];
    const auto first_px = ground ? static_cast<float>(ground->disparityAt(
                                       kCellCentre_px, kCellSide_px * v + kCellCentre_px))
                                 : 0.0f;
    for (int u = 0; u < usable.cols; ++u) {
      const float d = disparity[u], expected = first_px + per_column_px * static_cast<float>(u);
      of_row[u] = (d >= least_px) & (d * (h - margin_m) > expected * h) ? 1 : 0;
    }
  }
  return usable;
}

JoinedCells joinSurfaces(const StereoRig& rig, const DepthCells& cells, const cv::Mat1b& usable) {
  const int columns = usable.cols;
  const auto step_per_px2 = kStep_m / static_cast<float>(rig.disparityTimesDepth());
  JoinedCells joined(usable.rows * columns);
  const float *const disparity = cells.disparity_px[0], *const variance = cells.variance_px2[0];
  const auto joinIfLevel = [&](int i, int j) {
    if (joined.areJoined(i, j)) return;
    const float d = disparity[i], e = disparity[j];
    const float larger = std::max(d, e);
    const float margin = std::max(kStep_px, step_per_px2 * larger * larger) - std::abs(d - e);
    if (margin >= 0 && margin * margin >= kSigmas * kSigmas * (variance[i] + variance[j]))
      joined.join(i, j);
  };
  for (int v = 0; v < usable.rows; ++v) {
    const uchar* const row = usable[v];
    const uchar* const above = v > 0 ? usable[v - 1] : nullptr;
    const uchar* const second = v > 1 ? usable[v - 2] : nullptr;
    for (int u = 0; u < columns; ++u) {
      if (!row[u]) continue;
      const int i = v * columns + u;
      joined.add(i);
      if (u > 0 && row[u - 1])
        joinIfLevel(i, i - 1);
      else if (u > 1 && row[u - 2])
        joinIfLevel(i, i - 2);
      if (!above) continue;
      if (u > 0 && above[u - 1]) joinIfLevel(i, i - columns - 1);
      if (u + 1 < columns && above[u + 1]) joinIfLevel(i, i - columns + 1);
      if (above[u])
        joinIfLevel(i, i - columns);
      else if (second && second[u])
        joinIfLevel(i, i - 2 * columns);
    }
  }
  return joined;
}

// Whether a cell ends its obstacle: a farther surface begins beside it.
class ObstacleEnds {
 public:
  ObstacleEnds(const cv::Mat1i& number, const cv::Mat1f& disparity_px)
      : number_(number), disparity_px_(disparity_px) {}

  /// 0 on cells that end an obstacle or are on none, 255 elsewhere.
  void innerRow(int v, uchar* inner) const {
    const int last = number_.cols - 1;
    const int32_t* const number = number_[v];
    for (int u = 0; u <= last; ++u) inner[u] = number[u] >= 0 ? 255 : 0;
    for (int t = std::max(v - 1, 0); t <= std::min(v + 1, number_.rows - 1); ++t)
      for (int step = -1; step <= 1; ++step) dropEnds(v, t, step, inner);
  }

 private:
  // Without branches, so that compilers vectorise the loop.
  void dropEnds(int v, int t, int step, uchar* inner) const {
    const int32_t *const number = number_[v], *const other = number_[t];
    const float *const disparity = disparity_px_[v], *const behind = disparity_px_[t];
    const int end = number_.cols - std::max(step, 0);
    for (int u = std::max(-step, 0); u < end; ++u)
      inner[u] = static_cast<uchar>(
          inner[u] &
          ((other[u + step] != number[u]) & (behind[u + step] < disparity[u]) ? 0 : 255));
  }

  const cv::Mat1i& number_;
  const cv::Mat1f& disparity_px_;
};

}  // namespace

Obstacles::Obstacles(cv::Mat1i number, const std::vector<int>& sizes) : number_(number), ends_{0} {
  for (int size : sizes) ends_.push_back(ends_.back() + size);
  cells_.resize(static_cast<size_t>(ends_.back()));
  std::vector<int> next(ends_.begin(), ends_.end() - 1);
  for (int v = 0; v < number_.rows; ++v)
    for (int u = 0; u < number_.cols; ++u)
      if (const int k = number_(v, u); k >= 0)
        cells_[static_cast<size_t>(next[static_cast<size_t>(k)]++)] = {u, v};
}

cv::Rect Obstacles::Cells::area() const {
  cv::Point least = *first_, most = *first_;
  for (const cv::Point& p : *this) {
    least = {std::min(least.x, p.x), std::min(least.y, p.y)};
    most = {std::max(most.x, p.x), std::max(most.y, p.y)};
  }
  return {least, most + cv::Point(1, 1)};
}

Obstacles findObstacles(const StereoRig& rig, const DepthCells& cells,
                        const std::optional<GroundPlane>& ground) {
  const cv::Mat1b usable = usableCells(rig, cells, ground);
  JoinedCells joined = joinSurfaces(rig, cells, usable);
  // Roots come first: a set's first cell is its root.
  cv::Mat1i number(usable.size(), -1);
  std::vector<int> sizes;
  int* const number_of = number[0];
  for (int i = 0; i < static_cast<int>(usable.total()); ++i) {
    if (!usable.data[i]) continue;
    const int root = joined.rootOf(i);
    if (root == i) {
      number_of[i] = static_cast<int>(sizes.size());
      sizes.push_back(0);
    } else {
      number_of[i] = number_of[root];
    }
    ++sizes[static_cast<size_t>(number_of[i])];
  }
  return Obstacles(number, sizes);
}

cv::Mat1f obstacleWidths(const Obstacles& obstacles, const DepthCells& cells) {
  const cv::Mat1i& number = obstacles.number();
  cv::Mat1b inner(number.size());
  const ObstacleEnds ends(number, cells.disparity_px);
  for (int v = 0; v < number.rows; ++v) ends.innerRow(v, inner[v]);
  cv::Mat1f from_end, width_px(number.size(), kWide_px);
  cv::distanceTransform(inner, from_end, cv::DIST_C, 3);
  for (int k = 0; k < obstacles.size(); ++k) {
    float most = 0;
    for (const cv::Point p : obstacles[k]) most = std::max(most, from_end(p));
    for (const cv::Point p : obstacles[k]) width_px(p) = kCellSide_px * (2 * most + 1);
  }
  return width_px;
}

}  // namespace predictive_stereo
