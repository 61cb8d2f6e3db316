#include "odometry/block_kernel.h"

#include <algorithm>

#include "matching/simd_dispatch.h"
#include "predictive_stereo/simd_target.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "odometry/block_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
namespace {

#if PREDICTIVE_STEREO_HAS_VECTORS

// One position per lane.
void multiplyBlocks(const float (&block)[kBlockArea], const uint8_t* row, size_t step,
                    int positions, const BlockProducts& sums) {
  const hn::CappedTag<float, 8> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<uint8_t, decltype(d)> d8;
  const int lanes = static_cast<int>(hn::Lanes(d));
  if (positions < lanes) {
    referenceBlockKernel()(block, row, step, positions, sums);
    return;
  }
  for (int first = 0; first < positions; first += lanes) {
    first = std::min(first, positions - lanes);  // the last vector may overlap the one before
    auto grey = hn::Zero(d), grey_grey = hn::Zero(d), products = hn::Zero(d);
    for (int y = 0; y < kBlockSize; ++y)
      for (int x = 0; x < kBlockSize; ++x) {
        const uint8_t* at = row + static_cast<size_t>(y) * step + first + x;
        const auto g = hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d8, at)));
        grey = hn::Add(grey, g);
        grey_grey = hn::Add(grey_grey, hn::Mul(g, g));
        products = hn::Add(products, hn::Mul(hn::Set(d, block[y * kBlockSize + x]), g));
      }
    hn::StoreU(hn::ConvertTo(di, grey), di, sums.grey + first);
    hn::StoreU(hn::ConvertTo(di, grey_grey), di, sums.grey_grey + first);
    hn::StoreU(hn::ConvertTo(di, products), di, sums.products + first);
  }
}

BlockKernel kernel() { return multiplyBlocks; }

#else

BlockKernel kernel() { return referenceBlockKernel(); }

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(kernel);

void multiplyBlocksReference(const float (&block)[kBlockArea], const uint8_t* row, size_t step,
                             int positions, const BlockProducts& sums) {
  for (int i = 0; i < positions; ++i) {
    int32_t grey = 0, grey_grey = 0, products = 0;
    for (int y = 0; y < kBlockSize; ++y)
      for (int x = 0; x < kBlockSize; ++x) {
        const int g = row[static_cast<size_t>(y) * step + i + x];
        grey += g;
        grey_grey += g * g;
        products += g * static_cast<int>(block[y * kBlockSize + x]);
      }
    sums.grey[i] = grey;
    sums.grey_grey[i] = grey_grey;
    sums.products[i] = products;
  }
}

}  // namespace

BlockKernel referenceBlockKernel() { return multiplyBlocksReference; }

BlockKernel blockKernel(int64_t target_bit) {
  if (target_bit == kScalarTarget) return referenceBlockKernel();
  return PREDICTIVE_STEREO_DISPATCH(kernel, target_bit)();
}

BlockKernel bestBlockKernel() {
  static const BlockKernel best = blockKernel(simdTargetBit(chooseSimdTarget("auto")));
  return best;
}

}  // namespace predictive_stereo
#endif
