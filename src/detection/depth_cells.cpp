#include "detection/depth_cells.h"

#include <algorithm>
#include <limits>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr float kNone = std::numeric_limits<float>::max();

// Where a cell is measured: at its centre; if that is unknown, at another lattice point of it.
const cv::Point kPlaces[] = {{2, 2}, {0, 2}, {2, 0}, {0, 0}};

}  // namespace

void DepthCells::setFrame(const DisparityRange& range, const cv::Mat1f& map_px,
                          const cv::Mat1f& map_px2) {
  const cv::Size cells(map_px.cols / kCellSide_px, map_px.rows / kCellSide_px);
  disparity_px.create(cells);
  variance_px2.create(cells);
  const auto isKnown = [&](float d) { return range.isValid(d) && d > 0; };
  parallelFor(cv::Range(0, cells.height), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v)
      for (int u = 0; u < cells.width; ++u) {
        disparity_px(v, u) = variance_px2(v, u) = 0;
        for (const cv::Point place : kPlaces) {
          const cv::Point at(kCellSide_px * u + place.x, kCellSide_px * v + place.y);
          if (!isKnown(map_px(at))) continue;
          disparity_px(v, u) = map_px(at);
          variance_px2(v, u) = map_px2(at);
          break;
        }
      }
  });

  const cv::Size lattice((map_px.cols + 1) / kLatticeStep_px, (map_px.rows + 1) / kLatticeStep_px);
  nearest_px.create(lattice);
  farthest_px.create(lattice);
  parallelFor(cv::Range(0, lattice.height), [&](const cv::Range& rows) {
    cv::Mat1f largest(1, lattice.width + 2, 0.0f), smallest(1, lattice.width + 2, kNone);
    for (int v = rows.start; v < rows.end; ++v) {
      largest.setTo(0);
      smallest.setTo(kNone);
      for (int row = std::max(v - 1, 0); row <= std::min(v + 1, lattice.height - 1); ++row) {
        const float* const of_row = map_px[kLatticeStep_px * row];
        for (int u = 0; u < lattice.width; ++u) {
          const float d = of_row[kLatticeStep_px * u];
          largest(u + 1) = std::max(largest(u + 1), isKnown(d) ? d : 0.0f);
          smallest(u + 1) = std::min(smallest(u + 1), isKnown(d) ? d : kNone);
        }
      }
      for (int u = 0; u < lattice.width; ++u) {
        nearest_px(v, u) = std::max({largest(u), largest(u + 1), largest(u + 2)});
        const float least = std::min({smallest(u), smallest(u + 1), smallest(u + 2)});
        farthest_px(v, u) = least == kNone ? 0 : least;
      }
    }
  });
}

}  // namespace predictive_stereo
