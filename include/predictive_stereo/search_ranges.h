/// The search ranges of the matcher, from prediction and half-resolution match.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/prediction.h"

namespace predictive_stereo {

enum class SearchScheme {
  kFull,   ///< every disparity, every frame: the reference
  kPaper,  ///< section 2.4: d +- p of the prediction; the whole range near discontinuities and
           ///< without prediction
  /// Hull of prediction and half-resolution match, widened. Without both, the hull of the known
  /// ranges within some 16 px; if there are none, the whole range.
  kPredictive,
};

struct SearchRangeParams {
  SearchScheme scheme = SearchScheme::kPredictive;
  double margin_px = 2.25;     ///< minimum widening on both sides; 0 as in the paper: none
  double margin_sigma = 3.0;   ///< predictive: widening by this many predicted standard deviations
  double max_margin_px = 4.0;  ///< predictive: maximum widening

  template <class Visitor>
  void visit(Visitor&& v) {
    v("scheme", scheme,
      Choices<SearchScheme>{{"full", SearchScheme::kFull},
                            {"paper", SearchScheme::kPaper},
                            {"predictive", SearchScheme::kPredictive}});
    v("margin_px", margin_px, 0.0, 64.0);
    v("margin_sigma", margin_sigma, 0.0, 10.0);
    v("max_margin_px", max_margin_px, 0.0, 64.0);
  }
};

/// Number of disparities in each range; 0 where nothing is searched.
/// @param width_px  output of the ranges' size.
void searchWidths(const SearchRanges& ranges, cv::Mat1w& width_px);

/// Builds the search ranges of one frame. Keeps its buffers between calls.
class SearchRangeBuilder {
 public:
  /// @throws std::invalid_argument if a parameter is outside its limits, or if
  ///   params.max_margin_px < params.margin_px.
  SearchRangeBuilder(const DisparityRange& range, const SearchRangeParams& params);

  /// @param prediction  of the images' size.
  /// @param coarse_disparity_px  from CoarseMatcher, of size (width / 2, height / 2), which is not
  ///   checked; may be empty. Only kPredictive uses it.
  /// @param ranges  output of the images' size, within the disparity range.
  void build(const Prediction& prediction, const cv::Mat1f& coarse_disparity_px,
             SearchRanges& ranges);

 private:
  void aroundPrediction(const Prediction& prediction, SearchRanges& ranges) const;
  void unite(const Prediction& prediction, const cv::Mat1f& coarse_disparity_px,
             SearchRanges& ranges);
  void addToTiles(int y, const SearchRanges& ranges);
  void clipAndFillEmpty(SearchRanges& ranges);

  DisparityRange range_;
  SearchRangeParams params_;
  SearchRanges coarse_;   // hulls of the half-resolution match
  SearchRanges tiles_;    // hull of each tile, then of it and its neighbours
  SearchRanges columns_;  // hull of each column of a row of tiles
};

}  // namespace predictive_stereo
