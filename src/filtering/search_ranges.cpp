#include "predictive_stereo/search_ranges.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "filtering/range_rows.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr int kTilePx = 16;
constexpr int kBandRows = 2 * kTilePx;

void create(cv::Size size, SearchRanges& ranges) {
  ranges.first.create(size);
  ranges.last.create(size);
}

RangeRow row(SearchRanges& ranges, int y) { return {ranges.first[y], ranges.last[y]}; }
ConstRangeRow constRow(const SearchRanges& ranges, int y) {
  return {ranges.first[y], ranges.last[y]};
}

cv::Size tilesOf(cv::Size size) {
  return {(size.width + kTilePx - 1) / kTilePx, (size.height + kTilePx - 1) / kTilePx};
}

// The 3x3 hulls of successive rows. Keeps the widened ranges of three rows, which stay in the
// cache.
class RollingHull {
 public:
  static constexpr int kMemoryRows = 4;

  // @param memory  kMemoryRows of its rows are used, from `memory_row` on.
  RollingHull(SearchRanges& memory, int memory_row, int rows)
      : memory_(memory), memory_row_(memory_row), rows_(rows) {}

  // @param widen  called with a row's number and the output for its ranges.
  template <class Widen>
  void hullOfRow(int y, const Widen& widen, const RangeRow& hull) {
    const int above = std::max(y - 1, 0), below = std::min(y + 1, rows_ - 1);
    for (next_ = std::max(next_, above); next_ <= below; ++next_) widen(next_, kept(next_));
    const ConstRangeRow around[3] = {constant(kept(above)), constant(kept(y)),
                                     constant(kept(below))};
    hullOfRows(around, memory_.first.cols, row(memory_, memory_row_ + 3), hull);
  }

 private:
  RangeRow kept(int y) const { return row(memory_, memory_row_ + y % 3); }
  static ConstRangeRow constant(const RangeRow& ranges) { return {ranges.first, ranges.last}; }

  SearchRanges& memory_;
  const int memory_row_, rows_;
  int next_ = 0;  // first row that is not widened yet
};

}  // namespace

void searchWidths(const SearchRanges& ranges, cv::Mat1w& width_px) {
  width_px.create(ranges.first.size());
  parallelForEach(width_px.rows,
                  [&](int y) { widthsOfRow(constRow(ranges, y), width_px.cols, width_px[y]); });
}

SearchRangeBuilder::SearchRangeBuilder(const DisparityRange& range, const SearchRangeParams& params)
    : range_(range), params_(params) {
  validate(params, "search/");
  if (params.max_margin_px < params.margin_px)
    throw std::invalid_argument(
        "search/max_margin_px = " + std::to_string(params.max_margin_px) +
        ": must not be below search/margin_px = " + std::to_string(params.margin_px));
}

void SearchRangeBuilder::build(const Prediction& prediction, const cv::Mat1f& coarse_disparity_px,
                               SearchRanges& ranges) {
  create(prediction.disparity_px.size(), ranges);
  if (params_.scheme == SearchScheme::kPaper) {
    aroundPrediction(prediction, ranges);
  } else if (params_.scheme == SearchScheme::kPredictive) {
    unite(prediction, coarse_disparity_px, ranges);
  } else {
    ranges.first.setTo(range_.min_disparity);
    ranges.last.setTo(range_.max_disparity());
  }
}

void SearchRangeBuilder::aroundPrediction(const Prediction& prediction,
                                          SearchRanges& ranges) const {
  const float smallest = static_cast<float>(range_.min_disparity);
  const float largest = static_cast<float>(range_.max_disparity());
  const float everything = 2.0f * static_cast<float>(range_.count);
  const float least = static_cast<float>(params_.margin_px);
  parallelForEach(ranges.first.rows, [&](int y) {
    const float* disparity = prediction.disparity_px[y];
    const float* variance = prediction.variance_px2[y];
    const uchar* missed = prediction.missed_frames[y];
    for (int x = 0; x < ranges.first.cols; ++x) {
      // Section 2.4: d +- p, where p is the variance; near discontinuities it spans everything.
      const bool known = disparity[x] >= smallest && missed[x] != kMovesByItself;
      const float margin = known ? std::max(variance[x], least) : everything;
      const float first = std::max(disparity[x] - margin, smallest);
      const float last = std::min(disparity[x] + margin, largest);
      ranges.first(y, x) = static_cast<short>(std::floor(first));
      ranges.last(y, x) = static_cast<short>(std::ceil(last));
    }
  });
}

void SearchRangeBuilder::unite(const Prediction& prediction, const cv::Mat1f& coarse_disparity_px,
                               SearchRanges& ranges) {
  const cv::Size size = ranges.first.size(), coarse_size = coarse_disparity_px.size();
  const float smallest = static_cast<float>(range_.min_disparity);
  const Margins margins{static_cast<float>(params_.margin_sigma),
                        static_cast<float>(params_.margin_px),
                        static_cast<float>(params_.max_margin_px)};
  const auto widen = [&](int y, const RangeRow& widened) {
    widenPredicted({prediction.disparity_px[y], prediction.variance_px2[y], prediction.near_edge[y],
                    prediction.missed_frames[y]},
                   size.width, margins, smallest, kMovesByItself, widened);
  };
  const auto widenCoarse = [&](int y, const RangeRow& widened) {
    widenMeasured(coarse_disparity_px[y], coarse_size.width, margins.least, smallest, widened);
  };

  constexpr int kMemoryRows = RollingHull::kMemoryRows;
  const int bands = (size.height + kBandRows - 1) / kBandRows;
  create({size.width, bands * kMemoryRows}, predicted_);
  create({coarse_size.width, bands * (kMemoryRows + 1)}, coarse_);
  create(tilesOf(size), tiles_);
  create({size.width, tiles_.first.rows}, columns_);
  parallelForEach(bands, [&](int band) {
    const int coarse_memory = band * (kMemoryRows + 1);
    RollingHull hull(predicted_, band * kMemoryRows, size.height);
    RollingHull coarse_hull(coarse_, coarse_memory, coarse_size.height);
    int coarse_y = -1;
    for (int y = band * kBandRows; y < std::min((band + 1) * kBandRows, size.height); ++y) {
      hull.hullOfRow(y, widen, row(ranges, y));
      ConstRangeRow coarse{nullptr, nullptr};
      if (!coarse_size.empty()) {
        const int wanted = std::min(y / 2, coarse_size.height - 1);
        const int memory_row = coarse_memory + kMemoryRows;
        if (coarse_y != wanted)
          coarse_hull.hullOfRow(wanted, widenCoarse, row(coarse_, memory_row));
        coarse_y = wanted;
        coarse = constRow(coarse_, memory_row);
      }
      uniteWithCoarse(coarse, coarse_size.empty() ? 0 : coarse_size.width, size.width,
                      row(ranges, y));
      addToTiles(y, size.height, constRow(ranges, y));
    }
  });
  clipAndFillEmpty(ranges);
}

// Rows must come in order; the last row of a tile completes the tile.
void SearchRangeBuilder::addToTiles(int y, int rows, const ConstRangeRow& ranges) {
  const int width = columns_.first.cols, tile_y = y / kTilePx;
  const RangeRow columns = row(columns_, tile_y);
  if (y % kTilePx == 0) {
    std::fill_n(columns.first, width, kEmptyFirst);
    std::fill_n(columns.last, width, kEmptyLast);
  }
  uniteRows(ranges, width, columns);
  if (y % kTilePx != kTilePx - 1 && y != rows - 1) return;
  const RangeRow tiles = row(tiles_, tile_y);
  for (int tile = 0; tile < tiles_.first.cols; ++tile) {
    const int begin = tile * kTilePx, end = std::min(begin + kTilePx, width);
    tiles.first[tile] = *std::min_element(columns.first + begin, columns.first + end);
    tiles.last[tile] = *std::max_element(columns.last + begin, columns.last + end);
  }
}

// The hull of a tile and its neighbours; the whole range if nothing is known there.
std::pair<short, short> SearchRangeBuilder::aroundTile(int tile_x, int tile_y) const {
  short first = kEmptyFirst, last = kEmptyLast;
  for (int i = std::max(tile_y - 1, 0); i <= std::min(tile_y + 1, tiles_.first.rows - 1); ++i)
    for (int j = std::max(tile_x - 1, 0); j <= std::min(tile_x + 1, tiles_.first.cols - 1); ++j) {
      first = std::min(first, tiles_.first(i, j));
      last = std::max(last, tiles_.last(i, j));
    }
  const auto smallest = static_cast<short>(range_.min_disparity);
  const auto largest = static_cast<short>(range_.max_disparity());
  if (first > last) return {smallest, largest};
  return {std::max(first, smallest), std::min(last, largest)};
}

// Cuts all ranges to that of the matcher, and replaces empty ones by the hull around their tile.
void SearchRangeBuilder::clipAndFillEmpty(SearchRanges& ranges) {
  const cv::Size size = ranges.first.size(), tiles = tiles_.first.size();
  parallelForEach(tiles.height, [&](int tile_y) {
    const RangeRow around = row(columns_, tile_y);
    for (int tile_x = 0; tile_x < tiles.width; ++tile_x) {
      const auto [first, last] = aroundTile(tile_x, tile_y);
      const int begin = tile_x * kTilePx, count = std::min(kTilePx, size.width - begin);
      std::fill_n(around.first + begin, count, first);
      std::fill_n(around.last + begin, count, last);
    }
    for (int y = tile_y * kTilePx; y < std::min((tile_y + 1) * kTilePx, size.height); ++y)
      cutRanges(constRow(columns_, tile_y), size.width, static_cast<short>(range_.min_disparity),
                static_cast<short>(range_.max_disparity()), row(ranges, y));
  });
}

}  // namespace predictive_stereo
