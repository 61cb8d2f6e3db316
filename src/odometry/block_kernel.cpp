#include "odometry/block_kernel.h"

#include <algorithm>
#include <cmath>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "odometry/block_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef PREDICTIVE_STEREO_BLOCK_MOMENTS
#define PREDICTIVE_STEREO_BLOCK_MOMENTS
namespace predictive_stereo {

/// Moments of a block's grey values: their sum, and their variance times its squared area.
struct BlockMoments {
  int32_t grey, variance;
};

inline BlockMoments momentsOf(BlockAt block) {
  int32_t grey = 0, grey_grey = 0;
  for (int y = 0; y < kBlockSize; ++y, block.corner += block.step)
    for (int x = 0; x < kBlockSize; ++x) {
      const int32_t g = block.corner[x];
      grey += g;
      grey_grey += g * g;
    }
  return {grey, kBlockArea * grey_grey - grey * grey};
}

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

namespace {

#if PREDICTIVE_STEREO_HAS_VECTORS

// One position per lane.
using D32 = hn::CappedTag<int32_t, 8>;
using V32 = hn::Vec<D32>;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(D32()));
static_assert(kBlockSize % kLanes == 0,
              "columns are whole vectors, and those of one may be read again");

// One lane holds the grey values of two rows, which are multiplied and added by one instruction.
constexpr int kPairs = kBlockSize / 2;
HWY_INLINE int32_t pairOf(uint8_t upper, uint8_t lower) { return upper | lower << 16; }
HWY_INLINE V32 pairsOf(const uint8_t* upper, const uint8_t* lower) {
  const D32 d;
  const hn::Rebind<uint8_t, D32> d8;
  return hn::Or(hn::PromoteTo(d, hn::LoadU(d8, upper)),
                hn::ShiftLeft<16>(hn::PromoteTo(d, hn::LoadU(d8, lower))));
}

// Sums of the products of pairs.
class PairSums {
 public:
  HWY_INLINE PairSums() : sum_(hn::Zero(D32())), rest_(hn::Zero(D32())) {}
  HWY_INLINE void add(V32 a, V32 b) {
    const D32 d;
    const hn::Repartition<int16_t, D32> d16;
    sum_ = hn::ReorderWidenMulAccumulate(d, hn::BitCast(d16, a), hn::BitCast(d16, b), sum_, rest_);
  }
  HWY_INLINE V32 total() const { return hn::RearrangeToOddPlusEven(sum_, rest_); }

 private:
  V32 sum_, rest_;
};

HWY_INLINE V32 sumOfColumns(const int32_t* columns) {
  const D32 d;
  V32 sum = hn::LoadU(d, columns);
  for (int x = 1; x < kBlockSize; ++x) sum = hn::Add(sum, hn::LoadU(d, columns + x));
  return sum;
}

void correlateBlocks(BlockAt block, BlockAt first, int positions, float* correlation) {
  const D32 d;
  const hn::RebindToFloat<D32> df;
  constexpr int kTogether = 72;  // positions; most searches have no more
  constexpr int kColumns = kTogether + kBlockSize;
  int32_t pattern[kPairs][kBlockSize];
  const auto [grey, variance] = momentsOf(block);
  for (int k = 0; k < kPairs; ++k, block.corner += 2 * block.step)
    for (int x = 0; x < kBlockSize; ++x)
      pattern[k][x] = pairOf(block.corner[x], block.corner[block.step + x]);

  while (positions > 0) {
    const int n = std::min(kTogether, positions), columns = n + kBlockSize - 1;
    int32_t pairs[kPairs][kColumns], greys[kColumns], squares[kColumns];
    for (int x = 0; x < columns; x += kLanes) {
      const int at = std::min(x, columns - kLanes);
      PairSums sum, square;
      for (int k = 0; k < kPairs; ++k) {
        const uint8_t* upper = first.corner + 2 * k * first.step + at;
        const V32 pair = pairsOf(upper, upper + first.step);
        hn::StoreU(pair, d, pairs[k] + at);
        sum.add(pair, hn::Set(d, pairOf(1, 1)));
        square.add(pair, pair);
      }
      hn::StoreU(sum.total(), d, greys + at);
      hn::StoreU(square.total(), d, squares + at);
    }
    HWY_ALIGN float found[kTogether];
    for (int i = 0; i < n; i += kLanes) {
      PairSums product;
      for (int k = 0; k < kPairs; ++k)
        for (int x = 0; x < kBlockSize; ++x)
          product.add(hn::LoadU(d, pairs[k] + i + x), hn::Set(d, pattern[k][x]));
      const V32 area = hn::Set(d, kBlockArea), sum = sumOfColumns(greys + i);
      const V32 common = hn::Sub(hn::Mul(area, product.total()), hn::Mul(hn::Set(d, grey), sum));
      const V32 other = hn::Sub(hn::Mul(area, sumOfColumns(squares + i)), hn::Mul(sum, sum));
      const auto variances =
          hn::Mul(hn::Set(df, static_cast<float>(variance)), hn::ConvertTo(df, other));
      hn::Store(hn::Div(hn::ConvertTo(df, common), hn::Sqrt(hn::Max(variances, hn::Set(df, 1)))),
                df, found + i);
    }
    std::copy_n(found, n, correlation);
    positions -= n;
    correlation += n;
    first.corner += n;
  }
}

BlockKernel kernel() { return correlateBlocks; }

#else

BlockKernel kernel() { return referenceBlockKernel(); }

#endif

}  // namespace
PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(kernel);

void correlateBlocksReference(BlockAt block, BlockAt first, int positions, float* correlation) {
  const BlockMoments of_block = momentsOf(block);
  for (int i = 0; i < positions; ++i, ++first.corner) {
    int32_t products = 0;
    for (size_t y = 0; y < kBlockSize; ++y)
      for (size_t x = 0; x < kBlockSize; ++x)
        products += block.corner[y * block.step + x] * first.corner[y * first.step + x];
    const BlockMoments other = momentsOf(first);
    const auto common = static_cast<float>(kBlockArea * products - of_block.grey * other.grey);
    const float variances =
        static_cast<float>(of_block.variance) * static_cast<float>(other.variance);
    correlation[i] = common / std::sqrt(std::max(variances, 1.f));
  }
}

}  // namespace

BlockKernel referenceBlockKernel() { return correlateBlocksReference; }

BlockKernel blockKernel(int64_t target_bit) {
  if (target_bit == kScalarTarget) return referenceBlockKernel();
  return PREDICTIVE_STEREO_DISPATCH(kernel, target_bit)();
}

BlockKernel blockKernelInUse() { return blockKernel(simdTargetBitInUse()); }

}  // namespace predictive_stereo
#endif
