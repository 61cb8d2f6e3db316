/// The inner loops of Patch, for every SIMD target and as a plain reference. All give the same
/// results, bit by bit: sums are taken over each column first, then over columns in a fixed order.
#pragma once

#include <cstddef>
#include <cstdint>

namespace predictive_stereo {

constexpr int kPatchSize = 12;    ///< side [px]
constexpr int kPatchStride = 16;  ///< floats per row; those beyond the patch are 0, or not read
constexpr int kFramedSize = kPatchSize + 2;  ///< with one more pixel on each side, for gradients

/// Zero-mean brightness and gradients of a patch.
struct PatchImages {
  alignas(32) float texture[kPatchSize * kPatchStride];
  alignas(32) float gradient_x[kPatchSize * kPatchStride];
  alignas(32) float gradient_y[kPatchSize * kPatchStride];
};

/// Sums over a patch of products of texture (t) and gradients (x, y).
struct PatchMoments {
  float tt, xx, xy, yy, xt, yt;
};

/// Sums over a square of another image: of its grey values, of their squares, and of their products
/// with a patch.
struct PatchProducts {
  float grey, grey_grey, texture_grey, x_grey, y_grey;
};

/// Weights of the four pixels around a sub-pixel position.
struct BilinearWeights {
  float w00, w01, w10, w11;
};

/// A patch with its frame, rows of kPatchStride; columns beyond kFramedSize are undefined.
struct FramedPatch {
  alignas(32) float grey[(kFramedSize + 1) * kPatchStride];
};

/// The kFramedSize columns and rows to sample, in ascending order: pixel and fraction. Further
/// entries are valid columns.
struct SampleGrid {
  int column[kPatchStride], row[kPatchStride];
  float column_fraction[kPatchStride], row_fraction[kPatchStride];
};

struct PatchKernel {
  /// `corner`: the pixel above and to the left of the patch's upper left sample. Reads kReadColumns
  /// columns of kPatchSize + 1 rows.
  void (*multiply)(const PatchImages& patch, const uint8_t* corner, size_t step,
                   const BilinearWeights& weights, PatchProducts& products);
  /// Samples at a distance of one pixel. Reads kReadColumns columns of kFramedSize + 1 rows.
  void (*sample)(const uint8_t* corner, size_t step, const BilinearWeights& weights,
                 FramedPatch& framed);
  /// Samples at any distance. Reads kReadGridColumns columns from the grid's first column on.
  void (*sampleGrid)(const uint8_t* image, size_t step, const SampleGrid& grid,
                     FramedPatch& framed);
  void (*differentiate)(const FramedPatch& framed, PatchImages& images, PatchMoments& moments);
};

/// Vectors read columns beyond the patch, but no rows beyond those that samples need: see
/// kernelWithin in patch.cpp.
constexpr int kReadColumns = 17;
constexpr int kReadGridColumns = 33;

/// The kernel of a target (see simdTargetBit).
const PatchKernel& patchKernel(int64_t target_bit);
const PatchKernel& referencePatchKernel();
/// The kernel of the target in use (see useSimdTarget).
const PatchKernel& patchKernelInUse();

}  // namespace predictive_stereo
