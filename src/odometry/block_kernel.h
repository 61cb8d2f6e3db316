/// The inner loop of the stereo search: correlates one block with all blocks of a row, for every
/// SIMD target and as a plain reference. All give the same results, bit by bit: sums are integers.
#pragma once

#include <cstddef>
#include <cstdint>

namespace predictive_stereo {

constexpr int kBlockSize = 8;  ///< side [px]
constexpr int kBlockArea = kBlockSize * kBlockSize;

/// A block of kBlockSize rows and columns in an image's memory, given by its upper left pixel.
struct BlockAt {
  const uint8_t* corner;
  size_t step;
};

/// Zero-mean normalised correlation of `block` with `positions` successive blocks of a row, from
/// `first` on.
using BlockKernel = void (*)(BlockAt block, BlockAt first, int positions, float* correlation);

/// The kernel of a target (see simdTargetBit).
BlockKernel blockKernel(int64_t target_bit);
BlockKernel referenceBlockKernel();
/// The kernel of the target in use (see useSimdTarget).
BlockKernel blockKernelInUse();

}  // namespace predictive_stereo
