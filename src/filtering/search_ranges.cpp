#include "predictive_stereo/search_ranges.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/search_ranges.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

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

// Cuts ranges to [smallest, largest]; empty ones become the other ones.
void cutRanges(const int16_t* HWY_RESTRICT other_first, const int16_t* HWY_RESTRICT other_last,
               int width, int16_t smallest, int16_t largest, int16_t* HWY_RESTRICT first,
               int16_t* HWY_RESTRICT last) {
  for (int x = 0; x < width; ++x) {
    const bool unknown = first[x] > last[x];
    const int16_t cut_first = std::max(first[x], smallest), cut_last = std::min(last[x], largest);
    const int16_t otherwise_first = other_first[x], otherwise_last = other_last[x];
    first[x] = unknown ? otherwise_first : cut_first;
    last[x] = unknown ? otherwise_last : cut_last;
  }
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(widenPredictedPixels);
HWY_EXPORT(widenMeasuredPixels);
HWY_EXPORT(uniteWithCoarse);
HWY_EXPORT(unitePixels);
HWY_EXPORT(cutRanges);

constexpr int kTilePx = 16;

void create(cv::Size size, SearchRanges& ranges) {
  ranges.first.create(size);
  ranges.last.create(size);
}

RangeRow row(SearchRanges& ranges, int y) { return {ranges.first[y], ranges.last[y]}; }

// In place, from each range and those around it. Outside of the image there are none.
void hullOf3x3(SearchRanges& ranges) {
  if (ranges.first.empty()) return;
  constexpr int kBorder = cv::BORDER_CONSTANT | cv::BORDER_ISOLATED;
  parallelForEach(2, [&](int i) {
    if (i == 0)
      cv::erode(ranges.first, ranges.first, cv::Mat(), {-1, -1}, 1, kBorder);
    else
      cv::dilate(ranges.last, ranges.last, cv::Mat(), {-1, -1}, 1, kBorder);
  });
}

}  // namespace

void searchWidths(const SearchRanges& ranges, cv::Mat1w& width_px) {
  width_px.create(ranges.first.size());
  const auto count = [](short first, short last) {
    return static_cast<uint16_t>(std::max<short>(static_cast<short>(last - first + 1), 0));
  };
  parallelForEach(width_px.rows, [&](int y) {
    const short* const first = ranges.first[y];
    std::transform(first, first + width_px.cols, ranges.last[y], width_px[y], count);
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
  create(coarse_size, coarse_);
  parallelForEach(coarse_size.height, [&](int y) {
    HWY_DYNAMIC_DISPATCH(widenMeasuredPixels)
    (coarse_disparity_px[y], coarse_size.width, margins.least, smallest, coarse_.first[y],
     coarse_.last[y]);
  });
  hullOf3x3(coarse_);
  parallelForEach(size.height, [&](int y) {
    HWY_DYNAMIC_DISPATCH(widenPredictedPixels)
    (prediction.disparity_px[y], prediction.variance_px2[y], prediction.near_edge[y],
     prediction.missed_frames[y], size.width, margins, smallest, ranges.first[y], ranges.last[y]);
  });
  hullOf3x3(ranges);
  const cv::Size tiles((size.width + kTilePx - 1) / kTilePx, (size.height + kTilePx - 1) / kTilePx);
  create(tiles, tiles_);
  create({size.width, tiles.height}, columns_);
  parallelForEach(tiles.height, [&](int tile_y) {
    for (int y = tile_y * kTilePx; y < std::min((tile_y + 1) * kTilePx, size.height); ++y) {
      if (!coarse_size.empty()) {
        const RangeRow coarse = row(coarse_, std::min(y / 2, coarse_size.height - 1));
        HWY_DYNAMIC_DISPATCH(uniteWithCoarse)
        (coarse, coarse_size.width, size.width, row(ranges, y));
      }
      addToTiles(y, ranges);
    }
  });
  hullOf3x3(tiles_);
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

// Cuts all ranges to that of the matcher, and replaces empty ones by the hull around their tile.
void SearchRangeBuilder::clipAndFillEmpty(SearchRanges& ranges) {
  const cv::Size size = ranges.first.size(), tiles = tiles_.first.size();
  const auto smallest = static_cast<short>(range_.min_disparity);
  const auto largest = static_cast<short>(range_.max_disparity());
  parallelForEach(tiles.height, [&](int tile_y) {
    const RangeRow around = row(columns_, tile_y);
    for (int tile_x = 0; tile_x < tiles.width; ++tile_x) {
      // The whole range if nothing is known there.
      const short first = tiles_.first(tile_y, tile_x), last = tiles_.last(tile_y, tile_x);
      const int begin = tile_x * kTilePx, count = std::min(kTilePx, size.width - begin);
      std::fill_n(around.first + begin, count, first > last ? smallest : std::max(first, smallest));
      std::fill_n(around.last + begin, count, first > last ? largest : std::min(last, largest));
    }
    for (int y = tile_y * kTilePx; y < std::min((tile_y + 1) * kTilePx, size.height); ++y)
      HWY_DYNAMIC_DISPATCH(cutRanges)
    (around.first, around.last, size.width, smallest, largest, ranges.first[y], ranges.last[y]);
  });
}

}  // namespace predictive_stereo
#endif
