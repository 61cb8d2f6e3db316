/// Census transforms: what a pixel's neighbourhood looks like, as bits (section 2.1).
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// One comparison is one bit: is the first pixel darker than the second? Offsets from the centre.
struct CensusComparison {
  int first_x, first_y, second_x, second_y;
};

/// The comparisons of a census form; the first of them is bit 0.
class CensusPattern {
 public:
  static constexpr int kMostComparisons = 31;
  static constexpr int kMarginX = 4;  ///< farthest column of any form
  static constexpr int kMarginY = 3;  ///< farthest row of any form

  explicit CensusPattern(CensusForm form);

  const CensusComparison* begin() const { return comparisons_; }
  const CensusComparison* end() const { return comparisons_ + size_; }
  int size() const { return size_; }

 private:
  CensusComparison comparisons_[kMostComparisons];
  int size_ = 0;
};

/// The plain reference: one census word per pixel; the image's borders are replicated.
void censusReference(const cv::Mat1b& image, CensusForm form, cv::Mat1i& words);

}  // namespace predictive_stereo
