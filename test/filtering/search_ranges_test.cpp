#include "predictive_stereo/search_ranges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace predictive_stereo {
namespace {

// Multiples of 1/16 px, so that rounding outwards is exact in single precision.
float sixteenths(cv::RNG& rng, const DisparityRange& range) {
  return rng.uniform(16 * range.min_disparity, 16 * range.max_disparity()) / 16.0f;
}

Prediction randomPrediction(cv::Size size, const DisparityRange& range, uint64_t seed) {
  cv::RNG rng(seed);
  Prediction prediction;
  Predictor(range, PredictionParams()).predictNothing(size, prediction);
  for (int i = 0; i < size.area(); ++i) {
    if (rng.uniform(0, 5) == 0) continue;
    prediction.disparity_px(i) = sixteenths(rng, range);
    prediction.near_edge(i) = rng.uniform(0, 4) == 0 ? 255 : 0;
    prediction.missed_frames(i) = rng.uniform(0, 8) == 0 ? kMovesByItself : uchar{2};
    prediction.variance_px2(i) =
        prediction.near_edge(i) != 0 ? 1365.0f : rng.uniform(1, 144) / 16.0f;
  }
  return prediction;
}

// Unknown in its left part, so that some pixels have no known neighbours.
cv::Mat1f randomCoarse(cv::Size size, const DisparityRange& range, uint64_t seed) {
  cv::RNG rng(seed);
  cv::Mat1f coarse(size.height / 2, size.width / 2, range.invalid());
  for (float& d : coarse)
    if (rng.uniform(0, 3) != 0) d = sixteenths(rng, range);
  coarse.colRange(0, coarse.cols / 2).setTo(range.invalid());
  return coarse;
}

struct Interval {
  int first = 1 << 20, last = -(1 << 20);
  void include(double low, double high) {
    first = std::min(first, static_cast<int>(std::floor(low)));
    last = std::max(last, static_cast<int>(std::ceil(high)));
  }
};

// Interval of a pixel from prediction and half-resolution match; empty: first > last.
Interval known(const Prediction& prediction, const cv::Mat1f& coarse, const DisparityRange& range,
               const SearchRangeParams& params, int x, int y) {
  const cv::Size size = prediction.disparity_px.size();
  Interval interval;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, size.height - 1); ++v)
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, size.width - 1); ++u) {
      const float d = prediction.disparity_px(v, u);
      if (!range.isValid(d) || prediction.missed_frames(v, u) == kMovesByItself) continue;
      const double sigma = std::sqrt(prediction.variance_px2(v, u));
      const double margin =
          prediction.near_edge(v, u) != 0
              ? params.margin_px
              : std::clamp(params.margin_sigma * sigma, params.margin_px, params.max_margin_px);
      interval.include(d - margin, d + margin);
    }
  if (!coarse.empty()) {
    const int coarse_x = std::min(x / 2, coarse.cols - 1);
    const int coarse_y = std::min(y / 2, coarse.rows - 1);
    for (int v = std::max(coarse_y - 1, 0); v <= std::min(coarse_y + 1, coarse.rows - 1); ++v)
      for (int u = std::max(coarse_x - 1, 0); u <= std::min(coarse_x + 1, coarse.cols - 1); ++u)
        if (range.isValid(coarse(v, u)))
          interval.include(coarse(v, u) - params.margin_px, coarse(v, u) + params.margin_px);
  }
  return interval;
}

// Intervals of all pixels. Unknown pixels get the hull of the known ones in the 3x3 tiles around.
std::vector<Interval> naive(const Prediction& prediction, const cv::Mat1f& coarse,
                            const DisparityRange& range, const SearchRangeParams& params) {
  constexpr int kTile = 16;
  const cv::Size size = prediction.disparity_px.size();
  std::vector<Interval> known_ranges;
  for (int i = 0; i < size.area(); ++i)
    known_ranges.push_back(
        known(prediction, coarse, range, params, i % size.width, i / size.width));
  std::vector<Interval> ranges = known_ranges;
  for (int i = 0; i < size.area(); ++i) {
    const int x = i % size.width, y = i / size.width;
    if (ranges[i].first > ranges[i].last)
      for (int j = 0; j < size.area(); ++j) {
        const int across = j % size.width / kTile - x / kTile,
                  down = j / size.width / kTile - y / kTile;
        if (std::abs(across) > 1 || std::abs(down) > 1) continue;
        ranges[i].first = std::min(ranges[i].first, known_ranges[j].first);
        ranges[i].last = std::max(ranges[i].last, known_ranges[j].last);
      }
    if (ranges[i].first > ranges[i].last)
      ranges[i].include(range.min_disparity, range.max_disparity());
    ranges[i].first = std::max(ranges[i].first, range.min_disparity);
    ranges[i].last = std::min(ranges[i].last, range.max_disparity());
  }
  return ranges;
}

TEST(SearchRanges, PredictiveIsTheHullOfWhatIsKnown) {
  for (const int min_disparity : {-16, 0, 16}) {
    const DisparityRange range{min_disparity, 64};
    for (const cv::Size size :
         {cv::Size(37, 23), cv::Size(2, 2), cv::Size(40, 1), cv::Size(1, 9), cv::Size(75, 99)}) {
      Prediction prediction = randomPrediction(size, range, 5);
      // An unknown corner, and an unknown strip from it to the other side.
      for (const cv::Rect& unknown : {cv::Rect(0, 0, 40, 60), cv::Rect(0, 30, size.width, 5)})
        prediction.disparity_px(unknown & cv::Rect({}, size)).setTo(range.invalid());
      const cv::Mat1f coarse = randomCoarse(size, range, 6);
      SearchRangeParams params;
      SearchRanges ranges;
      SearchRangeBuilder(range, params).build(prediction, coarse, ranges);
      const std::vector<Interval> all = naive(prediction, coarse, range, params);
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
          const Interval expected = all[y * size.width + x];
          ASSERT_EQ(ranges.first(y, x), expected.first) << size << " " << x << "," << y;
          ASSERT_EQ(ranges.last(y, x), expected.last) << size << " " << x << "," << y;
        }
    }
  }
}

TEST(SearchRanges, PaperSearchesAroundThePredictionByItsVariance) {
  const DisparityRange range{0, 128};
  const Prediction prediction = randomPrediction({50, 30}, range, 9);
  SearchRangeParams params;
  params.scheme = SearchScheme::kPaper;
  params.margin_px = 1;
  SearchRanges ranges;
  SearchRangeBuilder(range, params).build(prediction, cv::Mat1f(), ranges);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 50; ++x) {
      const float d = prediction.disparity_px(y, x), p = prediction.variance_px2(y, x);
      const bool moves = prediction.missed_frames(y, x) == kMovesByItself;
      const bool full = !range.isValid(d) || prediction.near_edge(y, x) != 0 || moves;
      const float margin = std::max(p, 1.0f);
      const int first = full ? 0 : std::max(0, static_cast<int>(std::floor(d - margin)));
      const int last = full ? 127 : std::min(127, static_cast<int>(std::ceil(d + margin)));
      ASSERT_EQ(ranges.first(y, x), first);
      ASSERT_EQ(ranges.last(y, x), last);
    }
}

TEST(SearchRanges, WithoutPredictionAndCoarseMatchEverythingIsSearched) {
  const DisparityRange range{-16, 64};
  Prediction nothing;
  Predictor(range, PredictionParams()).predictNothing({20, 10}, nothing);
  for (const SearchScheme scheme :
       {SearchScheme::kFull, SearchScheme::kPaper, SearchScheme::kPredictive}) {
    SearchRangeParams params;
    params.scheme = scheme;
    SearchRanges ranges;
    SearchRangeBuilder(range, params).build(nothing, cv::Mat1f(), ranges);
    EXPECT_EQ(cv::countNonZero(ranges.first != -16), 0);
    EXPECT_EQ(cv::countNonZero(ranges.last != 47), 0);
  }
}

TEST(SearchRanges, WidthsCountBothEnds) {
  SearchRanges ranges;
  ranges.first = (cv::Mat1s(1, 5) << -16, 3, 7, 8, -32000);
  ranges.last = (cv::Mat1s(1, 5) << 239, 3, 6, 2, -31745);
  cv::Mat1w widths;
  searchWidths(ranges, widths);
  EXPECT_EQ(cv::countNonZero(widths != (cv::Mat1w(1, 5) << 256, 1, 0, 0, 256)), 0);
}

TEST(SearchRanges, RefusesMarginsInTheWrongOrder) {
  SearchRangeParams params;
  params.margin_px = 5;
  params.max_margin_px = 3;
  EXPECT_THROW(SearchRangeBuilder(DisparityRange(), params), std::invalid_argument);
}

}  // namespace
}  // namespace predictive_stereo
