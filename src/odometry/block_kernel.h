/// The inner loop of the block search, for every SIMD target and as a plain reference.
#pragma once

#include <cstddef>
#include <cstdint>

namespace predictive_stereo {

constexpr int kBlockSize = 8;  ///< side [px]
constexpr int kBlockArea = kBlockSize * kBlockSize;

/// Sums over a block: of the grey values, of their squares, and of their products with another one.
/// Integers below 2^24: exact in whatever order.
struct BlockProducts {
  int32_t *grey, *grey_grey, *products;
};

/// For the blocks whose upper left pixels are row[0] .. row[positions - 1].
/// @param block  the other one, row by row: whole numbers from 0 to 255.
using BlockKernel = void (*)(const float (&block)[kBlockArea], const uint8_t* row, size_t step,
                             int positions, const BlockProducts& sums);

/// Of a target (see simdTargetBit).
BlockKernel blockKernel(int64_t target_bit);
BlockKernel referenceBlockKernel();
/// Of the best target, or of the one that PREDICTIVE_STEREO_SIMD names.
BlockKernel bestBlockKernel();

}  // namespace predictive_stereo
