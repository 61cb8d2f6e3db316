/// Small patches of the lattice, compared through sub-pixel positions; compiled for every SIMD
/// target and dispatched at run time. Every target gives the same results, bit by bit.
#pragma once

#include <cstddef>
#include <cstdint>

namespace predictive_stereo {

/// Grey values of 5x5 lattice points after their mean is taken away.
struct GreyPatch {
  static constexpr int kSide = 5, kStride = 8, kArea = kSide * kSide;
  float grey[kSide * kStride];  ///< row by row; what is beyond a row's first kSide has no meaning
};

/// Of a patch between pixels, bytes are read from the upper left one on: kPatchColumns of each of
/// kPatchRows rows.
constexpr int kPatchRows = GreyPatch::kSide + 1, kPatchColumns = GreyPatch::kStride + 1;

/// @param fx, fy  how far the patch's first point is from the upper left pixel.
void patchBetween(const uint8_t* upper_left, std::ptrdiff_t stride, float fx, float fy,
                  GreyPatch& patch);

/// Mean |difference| of a patch and the one there.
float patchDifference(const GreyPatch& patch, const uint8_t* upper_left, std::ptrdiff_t stride,
                      float fx, float fy);

/// Mean |grey|.
float patchTexture(const GreyPatch& patch);

}  // namespace predictive_stereo
