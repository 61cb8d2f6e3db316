/// The census transform in SIMD.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Equals censusReference; rows run in parallel.
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
