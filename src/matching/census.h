/// Census transforms: comparisons in a pixel's neighbourhood, as bits (section 2.1).
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// One comparison gives one bit: whether the first pixel is darker than the second. Offsets are
/// from the centre.
struct CensusComparison {
  int first_x, first_y, second_x, second_y;
};

/// The comparisons of a census form; the first of them is bit 0.
class CensusPattern {
 public:
  static constexpr int kMostComparisons = 31;
  static constexpr int kMarginX = 4;  ///< largest column offset of all forms
  static constexpr int kMarginY = 3;  ///< largest row offset of all forms

  explicit CensusPattern(CensusForm form);

  const CensusComparison* begin() const { return comparisons_; }
  const CensusComparison* end() const { return comparisons_ + size_; }
  int size() const { return size_; }

 private:
  CensusComparison comparisons_[kMostComparisons];
  int size_ = 0;
};

/// The reference in plain C++: one census word per pixel; the image's borders are replicated.
void censusReference(const cv::Mat1b& image, CensusForm form, cv::Mat1i& words);

}  // namespace predictive_stereo
