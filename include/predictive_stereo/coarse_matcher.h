/// Disparities at half resolution, from one stereo pair alone.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/matcher.h"
#include "predictive_stereo/region_filter.h"

namespace predictive_stereo {

/// Full search at half resolution. It gives the part of the search ranges that does not depend on
/// the past, and the samples for row alignment. It costs an eighth of a full search. Its census
/// window is always 5x5: a larger window covers twice as much of the scene here, and too many
/// edges.
class CoarseMatcher {
 public:
  /// @param params  of the full-resolution matcher; the disparity range is halved here.
  /// @param min_region_px  smaller regions, in pixels of the full resolution, become invalid; see
  ///   RegionFilter. Steps within a region are at most 1 px of the half resolution. 0: none.
  /// @throws std::invalid_argument as the constructor of StereoMatcher does.
  explicit CoarseMatcher(const MatcherParams& params, int min_region_px = 0);

  /// @param left, right  rectified 8-bit grey images of one size.
  /// @param disparity_px  output of size (width / 2, height / 2), in pixels of the **full**
  ///   resolution; params.range.invalid() where unknown. Pixel (x, y) covers the full-resolution
  ///   pixels (2x, 2y) to (2x + 1, 2y + 1).
  /// @param principal_offset_px  of the full resolution, see StereoMatcher.
  /// @throws std::invalid_argument if the images differ in size or are smaller than 2x2 pixels.
  void match(const cv::Mat1b& left, const cv::Mat1b& right, cv::Mat1f& disparity_px,
             double principal_offset_px = 0);

 private:
  MatcherParams full_params_;
  int min_region_px_;
  StereoMatcher matcher_;
  RegionFilter region_filter_;
  cv::Mat1b left_half_, right_half_;
  Match match_;
};

}  // namespace predictive_stereo
