/// Comparison of small patches of the lattice at sub-pixel positions, compiled for every SIMD
/// target and dispatched at run time. Every target gives the same results, bit by bit.
#pragma once

#include <cstddef>
#include <cstdint>

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

}  // namespace predictive_stereo
