#include "detection/suspicion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "detection/suspicion_rows.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr int kBand = 6;    // rows of cells in one task
constexpr int kMargin = 5;  // lattice points along the border that are left out
static_assert(kMargin >= 2 * kTextureReach, "texture is not known closer to the border");

template <class Map>
auto rowsAround(const Map& map, int v) {
  std::array<const typename Map::value_type*, kTextureSide> rows;
  for (int k = 0; k < kTextureSide; ++k) rows[k] = map[v + k - kTextureReach];
  return rows;
}

// Whether most pixels around a pixel have a similar disparity.
bool isWithinSurface(const cv::Mat1f& disparity_px, const DisparityRange& range, cv::Point p) {
  constexpr int kReach_px = 4;
  const int kFewestAlike = 6;  // of nine
  const float d = disparity_px(p);
  int alike = 0;
  for (int dy = -kReach_px; dy <= kReach_px; dy += kReach_px)
    for (int dx = -kReach_px; dx <= kReach_px; dx += kReach_px) {
      const float other = disparity_px(p.y + dy, p.x + dx);
      alike += range.isValid(other) && std::abs(other - d) <= 1 + 0.05f * d;
    }
  return alike >= kFewestAlike;
}

}  // namespace

const std::vector<cv::Point>& Suspicion::find(const cv::Mat1b& grey, const cv::Mat1f& mismatch,
                                              const cv::Mat1f& disparity_px,
                                              const DisparityRange& range,
                                              const LevelGround& ground,
                                              const MotionDetectionParams& params) {
  const int rows = std::max(grey.rows - 2 * kMargin, 0) / kCell;
  const int columns = std::max(grey.cols - 2 * kMargin, 0) / kCell;
  suspicion_.create(grey.size());
  cells_.create(rows, columns);
  worst_.create(rows, columns);
  // A map without columns has no rows of cells.
  cells_of_row_.assign(static_cast<size_t>(columns > 0 ? rows : 0), 0);
  suspects_of_row_.resize(cells_of_row_.size());
  const auto least = static_cast<float>(params.min_mismatch);
  const int rows_of_cells = static_cast<int>(cells_of_row_.size());
  parallelFor(cv::Range(0, (rows_of_cells + kBand - 1) / kBand), [&](const cv::Range& bands) {
    cv::Mat1w deviation(kBand * kCell + 2 * kTextureReach, grey.cols);
    for (int band = bands.start; band < bands.end; ++band) {
      const int end = std::min(kBand * (band + 1), rows_of_cells);
      const int above = kMargin + kBand * band * kCell - kTextureReach;  // the band's first row
      for (int v = above; v < kMargin + end * kCell + kTextureReach; ++v)
        greyDeviationRow(rowsAround(grey, v).data(), grey.cols, deviation[v - above]);
      for (int r = kBand * band; r < end; ++r) {
        const float* of_cells[kCell];
        for (int k = 0; k < kCell; ++k) {
          const int v = kMargin + r * kCell + k;
          suspicionRow(rowsAround(deviation, v - above).data(), mismatch[v], grey.cols, kGreyNoise,
                       suspicion_[v]);
          of_cells[k] = suspicion_[v] + kMargin;
        }
        const int suspicious = suspiciousCells(of_cells, columns, least, cells_[r], worst_[r]);
        cells_of_row_[static_cast<size_t>(r)] = suspicious;
        std::vector<cv::Point>& kept = suspects_of_row_[static_cast<size_t>(r)];
        kept.clear();
        for (int k = 0; k < suspicious; ++k) {
          const int place = worst_(r, k);
          const cv::Point worst(kMargin + cells_(r, k) * kCell + place % kCell,
                                kMargin + r * kCell + place / kCell);
          if (!ground.isLevel(worst) && isWithinSurface(disparity_px, range, 2 * worst))
            kept.push_back(2 * worst);
        }
      }
    }
  });
  const int suspicious = std::accumulate(cells_of_row_.begin(), cells_of_row_.end(), 0);
  share_ = static_cast<double>(suspicious) / std::max(rows * columns, 1);
  suspects_px_.clear();
  for (const auto& of_row : suspects_of_row_)
    suspects_px_.insert(suspects_px_.end(), of_row.begin(), of_row.end());
  return suspects_px_;
}

}  // namespace predictive_stereo
