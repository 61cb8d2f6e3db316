#include "detection/depth_cells.h"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr float kNone = std::numeric_limits<float>::max();

// Where a cell is measured: at its centre; if that is unknown, at another lattice point of it.
const cv::Point kPlaces[] = {{2, 2}, {0, 2}, {2, 0}, {0, 0}};

// Every second pixel and row of a map; `unknown` where it is unknown.
void sample(const DisparityRange& range, const cv::Mat1f& map_px, float unknown,
            cv::Mat1f& lattice) {
  lattice.create((map_px.rows + 1) / kLatticeStep_px, (map_px.cols + 1) / kLatticeStep_px);
  const float least =
      std::max(static_cast<float>(range.min_disparity), std::numeric_limits<float>::denorm_min());
  for (int v = 0; v < lattice.rows; ++v) {
    const float* const from = map_px[kLatticeStep_px * v];
    float* const to = lattice[v];
    for (int u = 0; u < lattice.cols; ++u) {
      const float d = from[kLatticeStep_px * u];
      to[u] = d >= least ? d : unknown;
    }
  }
}

}  // namespace

void DepthCells::setFrame(const DisparityRange& range, const cv::Mat1f& map_px,
                          const cv::Mat1f& map_px2) {
  const cv::Size cells(map_px.cols / kCellSide_px, map_px.rows / kCellSide_px);
  disparity_px.create(cells);
  variance_px2.create(cells);
  parallelFor(cv::Range(0, cells.height), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v)
      for (int u = 0; u < cells.width; ++u) {
        disparity_px(v, u) = variance_px2(v, u) = 0;
        for (const cv::Point place : kPlaces) {
          const cv::Point at(kCellSide_px * u + place.x, kCellSide_px * v + place.y);
          if (!range.isValid(map_px(at)) || !(map_px(at) > 0)) continue;
          disparity_px(v, u) = map_px(at);
          variance_px2(v, u) = map_px2(at);
          break;
        }
      }
  });
  runTogether(
      [&] {
        sample(range, map_px, 0, nearest_px);
        cv::dilate(nearest_px, nearest_px, cv::Mat());
      },
      [&] {
        sample(range, map_px, kNone, farthest_px);
        cv::erode(farthest_px, farthest_px, cv::Mat());
        for (int v = 0; v < farthest_px.rows; ++v)
          std::replace(farthest_px[v], farthest_px[v] + farthest_px.cols, kNone, 0.0f);
      });
}

}  // namespace predictive_stereo
