/// Census transforms: comparisons in a pixel's neighbourhood, as bits (section 2.1).
#pragma once

#include <array>
#include <opencv2/core.hpp>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// One comparison gives one bit: whether the first pixel is darker than the second. Offsets are
/// from the centre.
struct CensusComparison {
  int first_x, first_y, second_x, second_y;
};

constexpr int kCensusBits = 24;
constexpr int kCensusBytes = kCensusBits / 8;
constexpr int kCensusNibbles = kCensusBits / 4;  ///< groups of four bits
constexpr int kCensusMargin = 4;                 ///< largest column offset of all forms

/// The comparisons of a census form; the first of them is bit 0. The last ones may compare the
/// centre with itself, which gives 0.
using CensusPattern = std::array<CensusComparison, kCensusBits>;
CensusPattern censusPattern(CensusForm form);

/// The reference in plain C++: one census word per pixel; the image's borders are replicated.
void censusReference(const cv::Mat1b& image, CensusForm form, cv::Mat1i& words);

/// The census transform in SIMD; equals censusReference. Rows run in parallel.
class CensusKernel {
 public:
  CensusKernel(CensusForm form, int64_t simd_target) : form_(form), simd_target_(simd_target) {}

  void transform(const cv::Mat1b& image, cv::Mat1i& words);

 private:
  CensusForm form_;
  int64_t simd_target_;
  cv::Mat1b padded_;  ///< the image with replicated columns, as signed values
};

}  // namespace predictive_stereo
