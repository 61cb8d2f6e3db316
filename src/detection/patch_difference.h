#pragma once

#include <opencv2/core.hpp>

namespace predictive_stereo {

/// A square of 5x5 grey values, to be compared with places in other images.
class GreyPatchOf {
 public:
  /// @param x, y  its centre in `image` [px], rounded.
  GreyPatchOf(const cv::Mat1b& image, float x, float y);

  /// Mean of the squared differences from the image around (x, y) [px], each relative to the
  /// variance that noise and a small error of the place cause; infinity if a square leaves its
  /// image.
  /// @param scale  size of this patch in that image, relative to its own one.
  float differenceFrom(const cv::Mat1b& image, float x, float y, float scale) const;

 private:
  static constexpr int kReach = 2, kSide = 2 * kReach + 1;
  bool inside_ = false;
  float grey_[kSide * kSide], information_[kSide * kSide];
};

}  // namespace predictive_stereo
