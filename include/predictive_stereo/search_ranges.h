/// From prediction and half-resolution match to the disparities that are searched.
#pragma once

#include <opencv2/core.hpp>
#include <utility>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/prediction.h"

namespace predictive_stereo {

struct ConstRangeRow;

enum class SearchScheme {
  kFull,        ///< every disparity, every frame: the reference
  kPaper,       ///< d +- p of the prediction; everything near discontinuities or without prediction
  kPredictive,  ///< hull of prediction and half-resolution match, widened; with neither, what is
                ///< known within some 16 px around; everything where that is nothing
};

struct SearchRangeParams {
  SearchScheme scheme = SearchScheme::kPredictive;
  double margin_px = 2.25;     ///< least widening on both sides; the paper has none: 0
  double margin_sigma = 3.0;   ///< predictive: widening by this many predicted standard deviations
  double max_margin_px = 4.0;  ///< predictive: largest widening

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

/// Disparities in each range; 0 where nothing is searched.
void searchWidths(const SearchRanges& ranges, cv::Mat1w& width_px);

/// Builds the ranges of one frame. Keeps its buffers between calls.
class SearchRangeBuilder {
 public:
  /// @throws std::invalid_argument for parameters outside their limits, max_margin_px < margin_px.
  SearchRangeBuilder(const DisparityRange& range, const SearchRangeParams& params);

  /// @param coarse_disparity_px  from CoarseMatcher, (width / 2, height / 2); may be empty. The
  ///   paper's scheme does not use it.
  void build(const Prediction& prediction, const cv::Mat1f& coarse_disparity_px,
             SearchRanges& ranges);

 private:
  void aroundPrediction(const Prediction& prediction, SearchRanges& ranges) const;
  void unite(const Prediction& prediction, const cv::Mat1f& coarse_disparity_px,
             SearchRanges& ranges);
  void addToTiles(int y, int rows, const ConstRangeRow& ranges);
  std::pair<short, short> aroundTile(int tile_x, int tile_y) const;
  void cutAndOpen(SearchRanges& ranges);

  DisparityRange range_;
  SearchRangeParams params_;
  SearchRanges predicted_, coarse_;  // some rows of each band of the image
  SearchRanges tiles_;               // hulls of tiles
  SearchRanges columns_;             // of the columns of each row of tiles
};

}  // namespace predictive_stereo
