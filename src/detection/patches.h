/// Comparison of small patches of the lattice at sub-pixel positions. Every SIMD target gives the
/// same results, bit by bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

namespace predictive_stereo {

/// Zero-mean grey values of 5x5 lattice points.
struct GreyPatch {
  static constexpr int kSide = 5, kStride = 8, kArea = kSide * kSide;
  float grey[kSide * kStride];  ///< row by row; entries behind a row's first kSide are undefined
};

/// A patch at a sub-pixel position reads kPatchColumns bytes of each of kPatchRows rows, from the
/// upper left pixel on.
constexpr int kPatchRows = GreyPatch::kSide + 1, kPatchColumns = GreyPatch::kStride + 1;

/// @param fx, fy  position of the patch's first point relative to the upper left pixel, in [0, 1).
void patchBetween(const uint8_t* upper_left, std::ptrdiff_t stride, float fx, float fy,
                  GreyPatch& patch);

/// Mean |difference| between a patch and the patch at this position.
float patchDifference(const GreyPatch& patch, const uint8_t* upper_left, std::ptrdiff_t stride,
                      float fx, float fy);

/// Mean |grey|.
float patchTexture(const GreyPatch& patch);

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
