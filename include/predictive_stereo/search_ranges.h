/// From prediction and half-resolution match to the disparities that are searched.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/prediction.h"

namespace predictive_stereo {

enum class SearchScheme {
  kFull,       ///< every disparity, every frame: the reference
  kPaper,      ///< d +- p of the prediction; everything near discontinuities or without prediction
  kPredictive  ///< hull of prediction and half-resolution match, widened; everything with neither
};

struct SearchRangeParams {
  SearchScheme scheme = SearchScheme::kPredictive;
  double margin_px = 2.0;     ///< least widening on both sides
  double margin_sigma = 3.0;  ///< widening by this many predicted standard deviations

  template <class Visitor>
  void visit(Visitor&& v) {
    v("scheme", scheme,
      Choices<SearchScheme>{{"full", SearchScheme::kFull},
                            {"paper", SearchScheme::kPaper},
                            {"predictive", SearchScheme::kPredictive}});
    v("margin_px", margin_px, 0.0, 64.0);
    v("margin_sigma", margin_sigma, 0.0, 10.0);
  }
};

/// @param prediction  may be empty: nothing is predicted then.
/// @param coarse_disparity_px  from CoarseMatcher; may be empty with the paper's scheme.
void buildSearchRanges(const Prediction& prediction, const cv::Mat1f& coarse_disparity_px,
                       cv::Size size, const DisparityRange& range, const SearchRangeParams& params,
                       SearchRanges& ranges);

}  // namespace predictive_stereo
