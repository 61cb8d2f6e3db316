/// The inner loops of Patch, for every SIMD target and as a plain reference. All give the same
/// results, bit by bit: sums are taken by columns first and then in one fixed order.
#pragma once

#include <cstddef>
#include <cstdint>

namespace predictive_stereo {

constexpr int kPatchSize = 12;    ///< side [px]
constexpr int kPatchStride = 16;  ///< floats from row to row; beyond the patch 0, or not read
constexpr int kFramedSize = kPatchSize + 2;  ///< with one more pixel on every side, for gradients

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

/// Sums over the same square of another image: of its grey values, of their squares, and of their
/// products with a patch.
struct PatchProducts {
  float grey, grey_grey, texture_grey, x_grey, y_grey;
};

/// Weights of the four pixels around a sub-pixel position.
struct BilinearWeights {
  float w00, w01, w10, w11;
};

/// A patch with its frame, rows of kPatchStride; columns beyond kFramedSize hold anything.
struct FramedPatch {
  alignas(32) float grey[(kFramedSize + 1) * kPatchStride];
};

/// The kFramedSize columns and rows to sample, in rising order: pixel and fraction. Entries beyond
/// are valid columns.
struct SampleGrid {
  int column[kPatchStride], row[kPatchStride];
  float column_fraction[kPatchStride], row_fraction[kPatchStride];
};

struct PatchKernel {
  /// `corner`: the pixel above and to the left of the patch's upper left sample. Reads
  /// kReadColumns of kPatchSize + 1 rows.
  void (*multiply)(const PatchImages& patch, const uint8_t* corner, size_t step,
                   const BilinearWeights& weights, PatchProducts& products);
  /// Samples of neighbouring pixels. Reads kReadColumns of kFramedSize + 1 rows.
  void (*sample)(const uint8_t* corner, size_t step, const BilinearWeights& weights,
                 FramedPatch& framed);
  /// Samples at any distance. Reads kReadGridColumns from the grid's first column on.
  void (*sampleGrid)(const uint8_t* image, size_t step, const SampleGrid& grid,
                     FramedPatch& framed);
  void (*differentiate)(const FramedPatch& framed, PatchImages& images, PatchMoments& moments);
};

/// Vectors read beyond the patch, but no more rows than samples need: see kernelWithin of
/// patch.cpp.
constexpr int kReadColumns = 17;
constexpr int kReadGridColumns = 33;

/// Of a target (see simdTargetBit).
const PatchKernel& patchKernel(int64_t target_bit);
const PatchKernel& referencePatchKernel();
/// Of the target in use (see useSimdTarget).
const PatchKernel& patchKernelInUse();

}  // namespace predictive_stereo
