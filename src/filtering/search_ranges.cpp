#include "predictive_stereo/search_ranges.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/search_ranges.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "simd/pixel_loop-inl.h"

#ifndef PREDICTIVE_STEREO_RANGE_ROWS
#define PREDICTIVE_STEREO_RANGE_ROWS
namespace predictive_stereo {

/// Ranges of one row. first > last: unknown.
struct RangeRow {
  int16_t* first;
  int16_t* last;
};

/// The empty range, which does not change a hull.
constexpr int16_t kEmptyFirst = INT16_MAX, kEmptyLast = INT16_MIN;

/// Margin around a disparity: `sigmas` standard deviations, clamped to [least, most]; `least` near
/// edges.
struct Margins {
  float sigmas, least, most;
};

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

// Floor and ceiling that compilers can vectorise; the offset makes every argument positive.
constexpr float kOffset = 1024.0f;
HWY_INLINE int16_t floorOf(float value) {
  return static_cast<int16_t>(static_cast<int>(value + kOffset) - static_cast<int>(kOffset));
}
HWY_INLINE int16_t ceilingOf(float value) {
  return static_cast<int16_t>(static_cast<int>(kOffset) - static_cast<int>(kOffset - value));
}

// Pointers are separate arguments that do not overlap: compilers vectorise these loops only then.
void widenPredictedPixels(const float* HWY_RESTRICT disparity_px,
                          const float* HWY_RESTRICT variance_px2,
                          const uint8_t* HWY_RESTRICT near_edge, const uint8_t* HWY_RESTRICT missed,
                          int width, Margins margins, float smallest_valid,
                          int16_t* HWY_RESTRICT first, int16_t* HWY_RESTRICT last) {
  for (int x = 0; x < width; ++x) {
    // Near discontinuities the hull with the neighbours covers both surfaces: the least margin is
    // enough.
    const float by_sigma = margins.sigmas * std::sqrt(variance_px2[x]);
    const float wanted = near_edge[x] != 0 ? margins.least : by_sigma;
    const float margin = std::min(std::max(wanted, margins.least), margins.most);
    const float d = disparity_px[x];
    const int16_t low = floorOf(d - margin), high = ceilingOf(d + margin);
    const bool known = (d >= smallest_valid) & (missed[x] != kMovesByItself);
    first[x] = known ? low : kEmptyFirst;
    last[x] = known ? high : kEmptyLast;
  }
}

void widenMeasuredPixels(const float* HWY_RESTRICT disparity_px, int width, float margin_px,
                         float smallest_valid, int16_t* HWY_RESTRICT first,
                         int16_t* HWY_RESTRICT last) {
  for (int x = 0; x < width; ++x) {
    const float d = disparity_px[x];
    const int16_t low = floorOf(d - margin_px), high = ceilingOf(d + margin_px);
    first[x] = d >= smallest_valid ? low : kEmptyFirst;
    last[x] = d >= smallest_valid ? high : kEmptyLast;
  }
}

// In place: the hull of each range and the two after it.
void hullAcross(int width, const RangeRow& row) {
  forPixels<int16_t>(0, width, [row](auto d, int x) HWY_ATTR {
    const auto at = [&](const int16_t* values, int i)
                        HWY_ATTR { return hn::LoadU(d, values + x + i); };
    hn::StoreU(hn::Min(hn::Min(at(row.first, 0), at(row.first, 1)), at(row.first, 2)), d,
               row.first + x);
    hn::StoreU(hn::Max(hn::Max(at(row.last, 0), at(row.last, 1)), at(row.last, 2)), d,
               row.last + x);
  });
}

// Pixel by pixel, the hull of three rows.
void hullOfRows(const RangeRow& a, const RangeRow& b, const RangeRow& c, int width,
                const RangeRow& hull) {
  forPixels<int16_t>(0, width, [=](auto d, int x) HWY_ATTR {
    const auto at = [&](const int16_t* values) HWY_ATTR { return hn::LoadU(d, values + x); };
    hn::StoreU(hn::Min(hn::Min(at(a.first), at(b.first)), at(c.first)), d, hull.first + x);
    hn::StoreU(hn::Max(hn::Max(at(a.last), at(b.last)), at(c.last)), d, hull.last + x);
  });
}

HWY_NOINLINE void uniteWithCoarsePixels(const int16_t* HWY_RESTRICT coarse_first,
                                        const int16_t* HWY_RESTRICT coarse_last, int pairs,
                                        int16_t* HWY_RESTRICT first, int16_t* HWY_RESTRICT last) {
  for (int x = 0; x < pairs; ++x) {
    first[2 * x] = std::min(first[2 * x], coarse_first[x]);
    first[2 * x + 1] = std::min(first[2 * x + 1], coarse_first[x]);
    last[2 * x] = std::max(last[2 * x], coarse_last[x]);
    last[2 * x + 1] = std::max(last[2 * x + 1], coarse_last[x]);
  }
}

// Unites `ranges` with those of half resolution.
void uniteWithCoarse(const RangeRow& coarse, int coarse_width, int width, const RangeRow& ranges) {
  uniteWithCoarsePixels(coarse.first, coarse.last, coarse_width, ranges.first, ranges.last);
  for (int x = 2 * coarse_width; x < width; ++x) {
    ranges.first[x] = std::min(ranges.first[x], coarse.first[coarse_width - 1]);
    ranges.last[x] = std::max(ranges.last[x], coarse.last[coarse_width - 1]);
  }
}

void unitePixels(const int16_t* HWY_RESTRICT first, const int16_t* HWY_RESTRICT last, int width,
                 int16_t* HWY_RESTRICT hull_first, int16_t* HWY_RESTRICT hull_last) {
  for (int x = 0; x < width; ++x) {
    hull_first[x] = std::min(hull_first[x], first[x]);
    hull_last[x] = std::max(hull_last[x], last[x]);
  }
}

// Cuts `ranges` to [smallest, largest]; empty ones become `otherwise`.
void cutRanges(const RangeRow& otherwise, int width, int16_t smallest, int16_t largest,
               const RangeRow& ranges) {
  forPixels<int16_t>(0, width, [=](auto d, int x) HWY_ATTR {
    const auto first = hn::LoadU(d, ranges.first + x), last = hn::LoadU(d, ranges.last + x);
    const auto unknown = hn::Gt(first, last);
    hn::StoreU(hn::IfThenElse(unknown, hn::LoadU(d, otherwise.first + x),
                              hn::Max(first, hn::Set(d, smallest))),
               d, ranges.first + x);
    hn::StoreU(hn::IfThenElse(unknown, hn::LoadU(d, otherwise.last + x),
                              hn::Min(last, hn::Set(d, largest))),
               d, ranges.last + x);
  });
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(widenPredictedPixels);
HWY_EXPORT(widenMeasuredPixels);
HWY_EXPORT(hullAcross);
HWY_EXPORT(hullOfRows);
HWY_EXPORT(uniteWithCoarse);
HWY_EXPORT(unitePixels);
HWY_EXPORT(cutRanges);

constexpr int kTilePx = 16;
constexpr int kBandRows = 2 * kTilePx;

void create(cv::Size size, SearchRanges& ranges) {
  ranges.first.create(size);
  ranges.last.create(size);
}

RangeRow row(SearchRanges& ranges, int y) { return {ranges.first[y], ranges.last[y]}; }

// The 3x3 hulls of the ranges that widen(y, ranges) makes of row y. After each row of hulls it
// calls finish(y), in order within bands of kBandRows.
template <class Widen, class Finish>
void hullOf3x3(const Widen& widen, SearchRanges& hull, const Finish& finish) {
  const int width = hull.first.cols, height = hull.first.rows, padded = width + 2;
  parallelForEach((height + kBandRows - 1) / kBandRows, [&](int band) {
    // The hulls along three rows, which stay in the cache.
    cv::AutoBuffer<int16_t, 6 * 2048> memory(static_cast<size_t>(6 * padded));
    const auto kept = [&](int y) {
      int16_t* const first = memory.data() + y % 3 * 2 * padded;
      return RangeRow{first, first + padded};
    };
    int next = std::max(band * kBandRows - 1, 0);  // first row that is not widened yet
    for (int y = band * kBandRows; y < std::min((band + 1) * kBandRows, height); ++y) {
      const int above = std::max(y - 1, 0), below = std::min(y + 1, height - 1);
      for (; next <= below; ++next) {
        const RangeRow widened = kept(next);
        widened.first[0] = widened.first[width + 1] = kEmptyFirst;
        widened.last[0] = widened.last[width + 1] = kEmptyLast;
        widen(next, RangeRow{widened.first + 1, widened.last + 1});
        HWY_DYNAMIC_DISPATCH(hullAcross)(width, widened);
      }
      HWY_DYNAMIC_DISPATCH(hullOfRows)(kept(above), kept(y), kept(below), width, row(hull, y));
      finish(y);
    }
  });
}

}  // namespace

void searchWidths(const SearchRanges& ranges, cv::Mat1w& width_px) {
  width_px.create(ranges.first.size());
  parallelForEach(width_px.rows, [&](int y) {
    const int width = width_px.cols;
    const int16_t *const first = ranges.first[y], *const last = ranges.last[y];
    uint16_t* const widths = width_px[y];
    for (int x = 0; x < width; ++x) {
      const auto count = static_cast<int16_t>(last[x] - first[x] + 1);
      widths[x] = static_cast<uint16_t>(std::max<int16_t>(count, 0));
    }
  });
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
    HWY_DYNAMIC_DISPATCH(widenPredictedPixels)
    (prediction.disparity_px[y], prediction.variance_px2[y], prediction.near_edge[y],
     prediction.missed_frames[y], size.width, margins, smallest, widened.first, widened.last);
  };
  const auto widenCoarse = [&](int y, const RangeRow& widened) {
    HWY_DYNAMIC_DISPATCH(widenMeasuredPixels)
    (coarse_disparity_px[y], coarse_size.width, margins.least, smallest, widened.first,
     widened.last);
  };

  create(coarse_size, coarse_);
  hullOf3x3(widenCoarse, coarse_, [](int) {});
  const cv::Size tiles((size.width + kTilePx - 1) / kTilePx, (size.height + kTilePx - 1) / kTilePx);
  create(tiles, tiles_);
  create({size.width, tiles.height}, columns_);
  hullOf3x3(widen, ranges, [&](int y) {
    if (!coarse_size.empty()) {
      const RangeRow coarse = row(coarse_, std::min(y / 2, coarse_size.height - 1));
      HWY_DYNAMIC_DISPATCH(uniteWithCoarse)
      (coarse, coarse_size.width, size.width, row(ranges, y));
    }
    addToTiles(y, ranges);
  });
  clipAndFillEmpty(ranges);
}

// Rows must come in order; the last row of a tile completes the tile.
void SearchRangeBuilder::addToTiles(int y, const SearchRanges& ranges) {
  const int width = columns_.first.cols, tile_y = y / kTilePx;
  const RangeRow columns = row(columns_, tile_y);
  if (y % kTilePx == 0) {
    std::fill_n(columns.first, width, kEmptyFirst);
    std::fill_n(columns.last, width, kEmptyLast);
  }
  HWY_DYNAMIC_DISPATCH(unitePixels)
  (ranges.first[y], ranges.last[y], width, columns.first, columns.last);
  if (y % kTilePx != kTilePx - 1 && y != ranges.first.rows - 1) return;
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
      HWY_DYNAMIC_DISPATCH(cutRanges)
    (around, size.width, static_cast<short>(range_.min_disparity),
     static_cast<short>(range_.max_disparity()), row(ranges, y));
  });
}

}  // namespace predictive_stereo
#endif
