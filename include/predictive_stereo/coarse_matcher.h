/// Disparities at half resolution, without any past.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/matcher.h"
#include "predictive_stereo/region_filter.h"

namespace predictive_stereo {

/// Full search at half resolution: the part of the search ranges that does not depend on the past,
/// and the samples for row alignment. Costs an eighth of a full search. Its census is 5x5, whatever
/// that of the full resolution is: a larger window, doubled, would reach across too many edges.
class CoarseMatcher {
 public:
  /// @param params  of the full-resolution matcher; its disparity range is halved.
  /// @param min_region_px  smaller regions, in pixels of the full resolution, are dropped; see
  ///   RegionFilter. Steps within a region are at most 1 px of the half resolution.
  explicit CoarseMatcher(const MatcherParams& params, int min_region_px = 0);

  /// @param disparity_px  of size (width / 2, height / 2), in pixels of the **full** resolution;
  ///   params.range.invalid() where unknown. Pixel (x, y) covers (2x, 2y) to (2x + 1, 2y + 1).
  /// @throws std::invalid_argument where the images differ in size or are too small.
  void match(const cv::Mat1b& left, const cv::Mat1b& right, cv::Mat1f& disparity_px);

 private:
  MatcherParams full_params_;
  int min_region_px_;
  StereoMatcher matcher_;
  RegionFilter region_filter_;
  cv::Mat1b left_half_, right_half_;
  Match match_;
};

}  // namespace predictive_stereo
