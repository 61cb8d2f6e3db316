/// The matcher on any search ranges, and the ranges made of any prediction.
#include <opencv2/core/utility.hpp>

#include "bytes.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/search_ranges.h"

using namespace predictive_stereo;

namespace {

void check(const Match& match, const DisparityRange& range) {
  for (int y = 0; y < match.disparity_px.rows; ++y)
    for (int x = 0; x < match.disparity_px.cols; ++x) {
      const float d = match.disparity_px(y, x);
      // Sub-pixel interpolation goes half a pixel beyond at most.
      const bool inside = d >= static_cast<float>(range.min_disparity) - 0.5f &&
                          d <= static_cast<float>(range.max_disparity()) + 0.5f;
      if (d != range.invalid() && !inside) finding("disparity " + std::to_string(d));
      if (match.search_width(y, x) > range.count) finding("more searched than there is");
    }
}

SearchRanges anyRanges(Bytes& bytes, cv::Size size) {
  SearchRanges ranges{cv::Mat1s(size), cv::Mat1s(size)};
  const bool wild = bytes.byte() % 4 == 0;
  for (int i = 0; i < size.area(); ++i) {
    const int x = i % size.width, y = i / size.width;
    if (wild) {
      ranges.first(y, x) = bytes.raw<int16_t>();
      ranges.last(y, x) = bytes.raw<int16_t>();
    } else {
      const int first = static_cast<int8_t>(bytes.byte());
      ranges.first(y, x) = static_cast<int16_t>(first);
      ranges.last(y, x) = static_cast<int16_t>(first + static_cast<int8_t>(bytes.byte()) / 4);
    }
  }
  return ranges;
}

Prediction anyPrediction(Bytes& bytes, cv::Size size, const DisparityRange& range) {
  Prediction prediction{cv::Mat1f(size, range.invalid()), cv::Mat1f(size, 0.0f),
                        cv::Mat1b(size, uchar{0}), cv::Mat1b(size, uchar{0})};
  for (int i = 0; i < size.area() && bytes.left() > 0; ++i) {
    const int x = i % size.width, y = i / size.width;
    const uint8_t kind = bytes.byte();
    if (kind % 4 == 0) continue;
    prediction.disparity_px(y, x) =
        static_cast<float>(range.min_disparity) + static_cast<float>(bytes.raw<uint16_t>()) / 256;
    prediction.variance_px2(y, x) =
        kind % 4 == 1 ? 0.1f : static_cast<float>(bytes.raw<uint16_t>());
    prediction.missed_frames(y, x) = kind % 8 == 7 ? kMovesByItself : uchar(kind % 3);
    prediction.near_edge(y, x) = kind & 64 ? 255 : 0;
  }
  return prediction;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  cv::setNumThreads(1);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Bytes bytes(data, size);
  MatcherParams params;
  params.range.min_disparity = bytes.whole(-20, 20);
  params.range.count = 16 * bytes.whole(1, 4);
  params.census = static_cast<CensusForm>(bytes.whole(0, 2));
  params.paths = static_cast<PathSet>(bytes.whole(0, 2));
  params.left_right_tolerance_px = bytes.whole(-1, 3);
  params.exact_ranges = bytes.byte() % 8 == 0;
  const cv::Size image(bytes.whole(1, 70), bytes.whole(1, 12));
  cv::Mat1b left(image), right(image);
  cv::theRNG().state = bytes.raw<uint64_t>();
  cv::randu(left, 0, 256);
  cv::randu(right, 0, 256);
  mayRefuse([&] {
    StereoMatcher matcher(params);
    Match match;
    SearchRanges ranges;
    if (bytes.byte() % 2) {
      ranges = anyRanges(bytes, image);
    } else {
      SearchRangeParams search;
      search.scheme = static_cast<SearchScheme>(bytes.whole(0, 2));
      search.margin_px = bytes.whole(0, 64);
      search.max_margin_px = bytes.whole(0, 64);
      SearchRangeBuilder builder(params.range, search);
      const cv::Mat1f coarse = bytes.byte() % 2
                                   ? cv::Mat1f()
                                   : cv::Mat1f(image / 2, static_cast<float>(bytes.whole(-30, 90)));
      builder.build(anyPrediction(bytes, image, params.range), coarse, ranges);
    }
    cv::Mat1w widths;
    searchWidths(ranges, widths);
    matcher.match(left, right, ranges, match);
    check(match, params.range);
  });
  return 0;
}
