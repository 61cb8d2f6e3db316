#include "detection/obstacles.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "detection/constants.h"
#include "detection/standing_cells.h"

namespace predictive_stereo {
namespace {

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

JoinedCells joinSurfaces(const StereoRig& rig, const DepthCells& cells, const cv::Mat1b& usable,
                         float least_step_px) {
  const int columns = usable.cols;
  const auto step_per_px2 = static_cast<float>(kGap_m / rig.disparityTimesDepth());
  JoinedCells joined(usable.rows * columns);
  const float *const disparity = cells.disparity_px[0], *const variance = cells.variance_px2[0];
  const auto joinIfLevel = [&](int i, int j) {
    if (joined.areJoined(i, j)) return;
    const float d = disparity[i], e = disparity[j];
    const float larger = std::max(d, e);
    // Standard deviations of the step have to be within it, too. Otherwise noise, as on a floor
    // without texture, joins all that touches it.
    const float margin = std::max(least_step_px, step_per_px2 * larger * larger) - std::abs(d - e);
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

// Of the cells' lattice points, and of those beyond the last cell.
cv::Mat1b onLattice(const cv::Mat1b& cells, cv::Size lattice) {
  if (cells.empty()) return cv::Mat1b::zeros(lattice);
  cv::Mat1b points;
  cv::resize(cells, points, {}, 2, 2, cv::INTER_NEAREST);
  cv::copyMakeBorder(points, points, 0, lattice.height - points.rows, 0,
                     lattice.width - points.cols, cv::BORDER_REPLICATE);
  return points;
}

// 255 on cells of an obstacle, 0 on those that end it: a farther surface begins beside them.
// @param numbers, disparities_px  three rows; `inner` is the middle one.
void innerCells(const int32_t* const numbers[3], const float* const disparities_px[3], int cells,
                uchar* inner) {
  const auto innerAt = [=](int left, int u, int right) {
    const int32_t own = numbers[1][u];
    const float d = disparities_px[1][u];
    bool is_end = own < 0;
    for (int k = 0; k < 3; ++k)
      for (int at : {left, u, right})
        is_end |= (numbers[k][at] != own) & (disparities_px[k][at] < d);
    return static_cast<uchar>(is_end ? 0 : 255);
  };
  const int last = cells - 1;
  // Without branches, so that compilers vectorise the loop.
  for (int u = 1; u < last; ++u) inner[u] = innerAt(u - 1, u, u + 1);
  if (cells == 0) return;
  inner[0] = innerAt(0, 0, std::min(1, last));
  inner[last] = innerAt(std::max(last - 1, 0), last, last);
}

}  // namespace

std::vector<cv::Point> Obstacles::cellsOf(int obstacle) const {
  std::vector<cv::Point> cells;
  cv::findNonZero(number == obstacle, cells);
  return cells;
}

Obstacles findObstacles(const StereoRig& rig, const DepthCells& cells,
                        const std::optional<GroundPlane>& ground, float camera_pixel_px) {
  cv::Mat1b standing = ground ? cellsAbove(*ground, cells) : cellsNotLevel(rig, cells);
  JoinedCells joined = joinSurfaces(rig, cells, standing, camera_pixel_px * kDisparityError_px);
  Obstacles obstacles{cv::Mat1i(standing.size(), -1), {}, {}};
  // Roots come first: a set's first cell is its root.
  int* const number = obstacles.number[0];
  const int count = static_cast<int>(obstacles.number.total());
  for (int i = 0; i < count; ++i) {
    if (!standing.data[i]) continue;
    const int root = joined.rootOf(i);
    number[i] = root == i ? static_cast<int>(obstacles.sizes.size()) : number[root];
    if (root == i) obstacles.sizes.push_back(0);
    ++obstacles.sizes[static_cast<size_t>(number[i])];
  }
  if (ground) addFeet(*ground, cells, standing);
  obstacles.standing = onLattice(standing, cells.lattice_px.size());
  return obstacles;
}

cv::Mat1f obstacleWidths(const Obstacles& obstacles, const DepthCells& cells) {
  const cv::Mat1i& number = obstacles.number;
  cv::Mat1b inner(number.size());
  for (int v = 0; v < inner.rows; ++v) {
    const int rows[] = {std::max(v - 1, 0), v, std::min(v + 1, inner.rows - 1)};
    const cv::Mat1f& d = cells.disparity_px;
    const int32_t* const numbers[] = {number[rows[0]], number[rows[1]], number[rows[2]]};
    const float* const disparities_px[] = {d[rows[0]], d[rows[1]], d[rows[2]]};
    innerCells(numbers, disparities_px, inner.cols, inner[v]);
  }
  cv::Mat1f from_end, width_px(inner.size(), kWide_px);
  cv::distanceTransform(inner, from_end, cv::DIST_C, 3);
  std::vector<float> most(obstacles.sizes.size(), 0);
  const int *const of_cell = number[0], count = static_cast<int>(number.total());
  const auto mostOf = [&](int i) -> float& { return most[static_cast<size_t>(of_cell[i])]; };
  for (int i = 0; i < count; ++i)
    if (of_cell[i] >= 0) mostOf(i) = std::max(mostOf(i), from_end[0][i]);
  for (int i = 0; i < count; ++i)
    if (of_cell[i] >= 0) width_px[0][i] = kCellSide_px * (2 * mostOf(i) + 1);
  return width_px;
}

}  // namespace predictive_stereo
