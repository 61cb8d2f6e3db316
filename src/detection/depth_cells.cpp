#include "detection/depth_cells.h"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr float kNone = std::numeric_limits<float>::max();

// The loops over rows have no branches, so that compilers vectorise them.

// Every second pixel of a row; where it is unknown, 0 in one row and kNone in the other.
void sampleRow(const float* row_px, float least_px, int width, float* lattice_px,
               float* or_none_px) {
  for (int u = 0; u < width; ++u) {
    const float d = row_px[kLatticeStep_px * u];
    lattice_px[u] = d >= least_px ? d : 0.0f;
    or_none_px[u] = d >= least_px ? d : kNone;
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
  lattice_px.create(lattice);
  or_none_px_.create(lattice);
  disparity_px.create(cells);
  variance_px2.create(cells);
  const float least_px =
      std::max(static_cast<float>(range.min_disparity), std::numeric_limits<float>::denorm_min());
  parallelForEach(lattice.height, [&](int v) {
    sampleRow(map_px[kLatticeStep_px * v], least_px, lattice.width, lattice_px[v], or_none_px_[v]);
  });
  parallelForEach(cells.height, [&](int v) {
    const float *const upper = lattice_px[2 * v], *const lower = lattice_px[2 * v + 1];
    const int y = kCellSide_px * v;
    cellRow(upper, lower, map_px2[y], map_px2[y + kCellCentre_px], cells.width, disparity_px[v],
            variance_px2[v]);
  });
  const cv::Mat1b around = cv::Mat1b::ones(3, 3);
  cv::dilate(lattice_px, nearest_px, around);
  cv::erode(or_none_px_, farthest_px, around);
  cv::threshold(farthest_px, farthest_px, kNone / 2, 0, cv::THRESH_TOZERO_INV);
}

}  // namespace predictive_stereo
