#include "predictive_stereo/search_ranges.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "filtering/range_rows.h"

namespace predictive_stereo {
namespace {

void create(cv::Size size, SearchRanges& ranges) {
  ranges.first.create(size);
  ranges.last.create(size);
}

RangeRow row(SearchRanges& ranges, int y) { return {ranges.first[y], ranges.last[y]}; }
ConstRangeRow constRow(const SearchRanges& ranges, int y) {
  return {ranges.first[y], ranges.last[y]};
}

// The 3x3 hull of row y; `hull` may be the row of another map.
void hullOfRow(const SearchRanges& ranges, int y, SearchRanges& scratch, const RangeRow& hull) {
  const int last = ranges.first.rows - 1;
  const ConstRangeRow rows[3] = {constRow(ranges, std::max(y - 1, 0)), constRow(ranges, y),
                                 constRow(ranges, std::min(y + 1, last))};
  hullOfRows(rows, ranges.first.cols, row(scratch, y), hull);
}

}  // namespace

void searchWidths(const SearchRanges& ranges, cv::Mat1w& width_px) {
  width_px.create(ranges.first.size());
  cv::parallel_for_(cv::Range(0, width_px.rows), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      widthsOfRow(constRow(ranges, y), width_px.cols, width_px[y]);
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
        ranges.first(y, x) = static_cast<short>(std::floor(first));
        ranges.last(y, x) = static_cast<short>(std::ceil(last));
      }
    }
  });
}

void SearchRangeBuilder::widenPrediction(const Prediction& prediction) {
  const cv::Size size = prediction.disparity_px.size();
  create(size, predicted_);
  const Margins margins{static_cast<float>(params_.margin_sigma),
                        static_cast<float>(params_.margin_px),
                        static_cast<float>(params_.max_margin_px)};
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      widenPredicted(prediction.disparity_px[y], prediction.variance_px2[y],
                     prediction.near_edge[y], size.width, margins,
                     static_cast<float>(range_.min_disparity), row(predicted_, y));
  });
}

void SearchRangeBuilder::widenCoarse(const cv::Mat1f& coarse_disparity_px) {
  const cv::Size size = coarse_disparity_px.size();
  create(size, coarse_);
  create(size, coarse_hull_);
  create(size, coarse_scratch_);
  if (size.empty()) return;
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      widenMeasured(coarse_disparity_px[y], size.width, static_cast<float>(params_.margin_px),
                    static_cast<float>(range_.min_disparity), row(coarse_, y));
  });
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      hullOfRow(coarse_, y, coarse_scratch_, row(coarse_hull_, y));
  });
}

void SearchRangeBuilder::unite(SearchRanges& ranges) {
  const cv::Size size = ranges.first.size(), coarse_size = coarse_.first.size();
  create(size, scratch_);
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      hullOfRow(predicted_, y, scratch_, row(ranges, y));
      const ConstRangeRow coarse =
          coarse_size.empty() ? ConstRangeRow{nullptr, nullptr}
                              : constRow(coarse_hull_, std::min(y / 2, coarse_size.height - 1));
      uniteWithCoarse(coarse, coarse_size.empty() ? 0 : coarse_size.width, size.width,
                      static_cast<short>(range_.min_disparity),
                      static_cast<short>(range_.max_disparity()), row(ranges, y));
    }
  });
}

}  // namespace predictive_stereo
