#include "detection/suspicion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "detection/suspicion_rows.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

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

void greyDeviation(const cv::Mat1b& grey, cv::Mat1w& deviation) {
  deviation.create(grey.size());
  const int last = std::max(grey.rows - kTextureReach, kTextureReach);
  parallelFor(cv::Range(kTextureReach, last), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v)
      greyDeviationRow(rowsAround(grey, v).data(), grey.cols, deviation[v]);
  });
}

const std::vector<cv::Point>& Suspicion::find(const cv::Mat1w& deviation, const cv::Mat1f& mismatch,
                                              const cv::Mat1f& disparity_px,
                                              const DisparityRange& range,
                                              const LevelGround& ground,
                                              const MotionDetectionParams& params) {
  const int rows = std::max(deviation.rows - 2 * kMargin, 0) / kCell;
  const int columns = std::max(deviation.cols - 2 * kMargin, 0) / kCell;
  // A map without columns has no rows of cells.
  cells_of_row_.assign(static_cast<size_t>(columns > 0 ? rows : 0), 0);
  suspects_of_row_.resize(cells_of_row_.size());
  const auto least = static_cast<float>(params.min_mismatch);
  parallelFor(cv::Range(0, static_cast<int>(cells_of_row_.size())), [&](const cv::Range& part) {
    cv::Mat1f suspicion(kCell, deviation.cols);
    std::vector<int32_t> cells(static_cast<size_t>(columns)), worst(cells.size());
    for (int r = part.start; r < part.end; ++r) {
      const int first = kMargin + r * kCell;
      const float* of_cells[kCell];
      for (int k = 0; k < kCell; ++k) {
        suspicionRow(rowsAround(deviation, first + k).data(), mismatch[first + k], deviation.cols,
                     kGreyNoise, suspicion[k]);
        of_cells[k] = suspicion[k] + kMargin;
      }
      const int suspicious = suspiciousCells(of_cells, columns, least, cells.data(), worst.data());
      cells_of_row_[static_cast<size_t>(r)] = suspicious;
      std::vector<cv::Point>& kept = suspects_of_row_[static_cast<size_t>(r)];
      kept.clear();
      for (size_t k = 0; k < static_cast<size_t>(suspicious); ++k) {
        const cv::Point at(kMargin + cells[k] * kCell + worst[k] % kCell, first + worst[k] / kCell);
        if (!ground.isLevel(at) && isWithinSurface(disparity_px, range, 2 * at))
          kept.push_back(2 * at);
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
