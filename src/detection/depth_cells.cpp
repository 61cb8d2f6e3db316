#include "detection/depth_cells.h"

#include <algorithm>
#include <limits>
#include <opencv2/core/utility.hpp>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr float kNone = std::numeric_limits<float>::max();

// The loops have no branches, so that compilers vectorise them.

// Every second pixel of a row; 0 where it is unknown.
void sampleRow(const float* row_px, float least_px, int width, float* lattice_px) {
  for (int u = 0; u < width; ++u) {
    const float d = row_px[kLatticeStep_px * u];
    lattice_px[u] = d >= least_px ? d : 0.0f;
  }
}

float smaller(float d, float e) { return d < e ? d : e; }
float larger(float d, float e) { return d > e ? d : e; }
float orNone(float d) { return d > 0 ? d : kNone; }

// Largest and smallest known disparity around the points of row v.
void extremesAround(const cv::Mat1f& lattice_px, int v, float* nearest_px, float* farthest_px) {
  const int width = lattice_px.cols;
  const float *a = lattice_px[std::max(v - 1, 0)], *b = lattice_px[v],
              *c = lattice_px[std::min(v + 1, lattice_px.rows - 1)];
  cv::AutoBuffer<float, 2048> of_columns(2 * static_cast<size_t>(width + 2));
  float *most = of_columns.data(), *least = most + width + 2;
  most[0] = most[width + 1] = 0;
  least[0] = least[width + 1] = kNone;
  for (int u = 0; u < width; ++u) {
    most[u + 1] = larger(larger(a[u], b[u]), c[u]);
    least[u + 1] = smaller(smaller(orNone(a[u]), orNone(b[u])), orNone(c[u]));
  }
  for (int u = 0; u < width; ++u) {
    nearest_px[u] = larger(larger(most[u], most[u + 1]), most[u + 2]);
    const float farthest = smaller(smaller(least[u], least[u + 1]), least[u + 2]);
    farthest_px[u] = farthest < kNone ? farthest : 0.0f;
  }
}

// A row of cells. Each one is measured at its centre; if that is unknown, at another lattice point
// of it.
/// @param upper_px, lower_px  lattice rows.
/// @param upper_px2, lower_px2  rows of pixels.
void cellRow(const float* upper_px, const float* lower_px, const float* upper_px2,
             const float* lower_px2, int cells, float* disparity_px, float* variance_px2) {
  for (int u = 0; u < cells; ++u) {
    const float corner = upper_px[2 * u], above = upper_px[2 * u + 1], left = lower_px[2 * u],
                centre = lower_px[2 * u + 1];
    float d = corner, variance = corner > 0 ? upper_px2[4 * u] : 0.0f;
    d = above > 0 ? above : d, variance = above > 0 ? upper_px2[4 * u + 2] : variance;
    d = left > 0 ? left : d, variance = left > 0 ? lower_px2[4 * u] : variance;
    d = centre > 0 ? centre : d, variance = centre > 0 ? lower_px2[4 * u + 2] : variance;
    disparity_px[u] = d;
    variance_px2[u] = variance;
  }
}

}  // namespace

void DepthCells::setFrame(const DisparityRange& range, const cv::Mat1f& map_px,
                          const cv::Mat1f& map_px2) {
  static_assert(kCellSide_px == 2 * kLatticeStep_px && kCellCentre_px == kLatticeStep_px);
  const cv::Size lattice((map_px.cols + 1) / kLatticeStep_px, (map_px.rows + 1) / kLatticeStep_px);
  const cv::Size cells(map_px.cols / kCellSide_px, map_px.rows / kCellSide_px);
  lattice_px_.create(lattice);
  nearest_px.create(lattice);
  farthest_px.create(lattice);
  disparity_px.create(cells);
  variance_px2.create(cells);
  const float least_px =
      std::max(static_cast<float>(range.min_disparity), std::numeric_limits<float>::denorm_min());
  parallelForEach(lattice.height, [&](int v) {
    sampleRow(map_px[kLatticeStep_px * v], least_px, lattice.width, lattice_px_[v]);
  });
  parallelForEach(lattice.height, [&](int v) {
    extremesAround(lattice_px_, v, nearest_px[v], farthest_px[v]);
    const int row = v / 2, y = kCellSide_px * row;
    if (v % 2 == 0 && row < cells.height)
      cellRow(lattice_px_[v], lattice_px_[v + 1], map_px2[y], map_px2[y + kCellCentre_px],
              cells.width, disparity_px[row], variance_px2[row]);
  });
}

}  // namespace predictive_stereo
