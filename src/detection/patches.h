/// Comparison of small squares of images.
#pragma once

#include <opencv2/core.hpp>

namespace predictive_stereo {

/// A square of 5x5 grey values, to be compared with places in other images.
class GreyPatch {
 public:
  /// @param x, y  its centre in `image` [px], rounded.
  GreyPatch(const cv::Mat1b& image, float x, float y);

  /// Whether the square may be brighter or darker in the other image.
  enum class Brightness { kSame, kMayDiffer };
  /// Mean of the squared differences from the image around (x, y) [px], each relative to the
  /// variance that noise and a small error of the place cause; infinity if a square leaves its
  /// image.
  /// @param scale  size of this patch in that image, relative to its own one.
  /// @param brightness  kMayDiffer: after subtracting the mean difference.
  float differenceFrom(const cv::Mat1b& image, float x, float y, float scale,
                       Brightness brightness = Brightness::kSame) const;

 private:
  static constexpr int kReach = 2, kSide = 2 * kReach + 1;
  bool inside_ = false;
  float grey_[kSide * kSide], information_[kSide * kSide];
};

}  // namespace predictive_stereo
