#include "predictive_stereo/search_ranges.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace predictive_stereo {
namespace {

// A range that contains nothing and leaves every hull as it is.
constexpr short kEmptyFirst = std::numeric_limits<short>::max();
constexpr short kEmptyLast = std::numeric_limits<short>::min();

void create(cv::Size size, SearchRanges& ranges) {
  ranges.first.create(size);
  ranges.last.create(size);
}

// Floor and ceiling that compilers turn into vector code; the offset makes every argument positive.
constexpr float kOffset = 1024.0f;
int floorOf(float value) { return static_cast<int>(value + kOffset) - static_cast<int>(kOffset); }
int ceilingOf(float value) { return -floorOf(-value); }

// The 3x3 hull of row y of `in`.
void hullRow(const SearchRanges& in, int y, short* first, short* last) {
  const int width = in.first.cols;
  const int above = std::max(y - 1, 0), below = std::min(y + 1, in.first.rows - 1);
  const short *first0 = in.first[above], *first1 = in.first[y], *first2 = in.first[below];
  const short *last0 = in.last[above], *last1 = in.last[y], *last2 = in.last[below];
  const auto lowest = [&](int x) { return std::min(std::min(first0[x], first1[x]), first2[x]); };
  const auto highest = [&](int x) { return std::max(std::max(last0[x], last1[x]), last2[x]); };
  const auto pixel = [&](int x, int left, int right) {
    first[x] = std::min(std::min(lowest(left), lowest(x)), lowest(right));
    last[x] = std::max(std::max(highest(left), highest(x)), highest(right));
  };
  pixel(0, 0, std::min(1, width - 1));
  for (int x = 1; x + 1 < width; ++x) pixel(x, x - 1, x + 1);
  pixel(width - 1, std::max(width - 2, 0), width - 1);
}

}  // namespace

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
    widenPrediction(prediction);
    widenCoarse(coarse_disparity_px);
    unite(ranges);
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
  cv::parallel_for_(cv::Range(0, ranges.first.rows), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const float* disparity = prediction.disparity_px[y];
      const float* variance = prediction.variance_px2[y];
      for (int x = 0; x < ranges.first.cols; ++x) {
        // Section 2.4: d +- p, where p is the variance; near discontinuities it spans everything.
        const bool known = disparity[x] >= smallest;
        const float margin = known ? std::max(variance[x], least) : everything;
        const float first = std::max(disparity[x] - margin, smallest);
        const float last = std::min(disparity[x] + margin, largest);
        ranges.first(y, x) = static_cast<short>(floorOf(first));
        ranges.last(y, x) = static_cast<short>(ceilingOf(last));
      }
    }
  });
}

void SearchRangeBuilder::widenPrediction(const Prediction& prediction) {
  const cv::Size size = prediction.disparity_px.size();
  create(size, predicted_);
  const float smallest = static_cast<float>(range_.min_disparity);
  const float least = static_cast<float>(params_.margin_px);
  const float most = static_cast<float>(params_.max_margin_px);
  const float sigmas = static_cast<float>(params_.margin_sigma);
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const float* disparity = prediction.disparity_px[y];
      const float* variance = prediction.variance_px2[y];
      const uchar* near_edge = prediction.near_edge[y];
      short* first = predicted_.first[y];
      short* last = predicted_.last[y];
      for (int x = 0; x < size.width; ++x) {
        // Near discontinuities the hull with the neighbours reaches across: no wider margin there.
        const float wanted = near_edge[x] != 0 ? least : sigmas * std::sqrt(variance[x]);
        const float margin = std::min(std::max(wanted, least), most);
        const bool known = disparity[x] >= smallest;
        first[x] = static_cast<short>(known ? floorOf(disparity[x] - margin) : kEmptyFirst);
        last[x] = static_cast<short>(known ? ceilingOf(disparity[x] + margin) : kEmptyLast);
      }
    }
  });
}

void SearchRangeBuilder::widenCoarse(const cv::Mat1f& coarse_disparity_px) {
  const cv::Size size = coarse_disparity_px.size();
  create(size, coarse_);
  create(size, coarse_hull_);
  if (size.empty()) return;
  const float smallest = static_cast<float>(range_.min_disparity);
  const float margin = static_cast<float>(params_.margin_px);
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const float* disparity = coarse_disparity_px[y];
      short* first = coarse_.first[y];
      short* last = coarse_.last[y];
      for (int x = 0; x < size.width; ++x) {
        const bool known = disparity[x] >= smallest;
        first[x] = static_cast<short>(known ? floorOf(disparity[x] - margin) : kEmptyFirst);
        last[x] = static_cast<short>(known ? ceilingOf(disparity[x] + margin) : kEmptyLast);
      }
    }
  });
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      hullRow(coarse_, y, coarse_hull_.first[y], coarse_hull_.last[y]);
  });
}

void SearchRangeBuilder::unite(SearchRanges& ranges) const {
  const cv::Size size = ranges.first.size(), coarse_size = coarse_.first.size();
  const short smallest = static_cast<short>(range_.min_disparity);
  const short largest = static_cast<short>(range_.max_disparity());
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      short* first = ranges.first[y];
      short* last = ranges.last[y];
      hullRow(predicted_, y, first, last);
      if (!coarse_size.empty()) {
        const int coarse_y = std::min(y / 2, coarse_size.height - 1);
        const short* coarse_first = coarse_hull_.first[coarse_y];
        const short* coarse_last = coarse_hull_.last[coarse_y];
        for (int x = 0; x < size.width; ++x) {
          const int coarse_x = std::min(x / 2, coarse_size.width - 1);
          first[x] = std::min(first[x], coarse_first[coarse_x]);
          last[x] = std::max(last[x], coarse_last[coarse_x]);
        }
      }
      for (int x = 0; x < size.width; ++x) {
        const bool known = first[x] <= last[x];
        first[x] = known ? std::max(first[x], smallest) : smallest;
        last[x] = known ? std::min(last[x], largest) : largest;
      }
    }
  });
}

}  // namespace predictive_stereo
