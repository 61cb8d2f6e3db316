#include "detection/residual_group_rows.h"

#include <algorithm>
#include <cmath>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/residual_group_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Processes points from u on in whole vectors; `u` is then the first point that is left over.
template <class D>
HWY_INLINE int seedsOf(D d, const float* const residuals[kResidualSide],
                       const uint8_t* HWY_RESTRICT pair, int end, const SeedLimits& limits, int& u,
                       uint8_t* HWY_RESTRICT seeds) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto unknown = hn::Set(d, limits.unknown), least = hn::Set(d, limits.least_mean),
             zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  HWY_ALIGN float sums[hn::MaxLanes(D())], is_seed[hn::MaxLanes(D())];
  int count = 0;
  for (; u + lanes <= end; u += lanes) {
    const auto centre = hn::LoadU(d, residuals[kResidualReach] + u);
    const auto large = hn::Ge(hn::Abs(centre), hn::Mul(hn::Set(d, 0.5f), least));
    const auto promising = hn::And(large, hn::Ne(centre, unknown));
    if (hn::AllFalse(d, promising)) continue;
    auto sum = zero, known = zero, sign = zero;
    for (int j = 0; j < kResidualSide; ++j)
      for (int i = -kResidualReach; i <= kResidualReach; ++i) {
        const auto residual = hn::LoadU(d, residuals[j] + u + i);
        const auto is_known = hn::Ne(residual, unknown);
        const auto usable = hn::IfThenElseZero(is_known, residual);
        sum = hn::Add(sum, usable);
        known = hn::Add(known, hn::IfThenElseZero(is_known, one));
        sign = hn::Add(sign, hn::IfThenElseZero(hn::Gt(usable, zero), one));
        sign = hn::Sub(sign, hn::IfThenElseZero(hn::Lt(usable, zero), one));
      }
    const auto enough = hn::Ge(known, hn::Set(d, static_cast<float>(limits.fewest_known)));
    const auto is_large = hn::Ge(hn::Abs(sum), hn::Mul(least, known));
    const auto one_sign = hn::Ge(hn::Abs(sign), hn::Mul(hn::Set(d, limits.least_sign), known));
    const auto seed = hn::And(hn::And(promising, enough), hn::And(is_large, one_sign));
    if (hn::AllFalse(d, seed)) continue;
    hn::Store(sum, d, sums);
    hn::Store(hn::IfThenElseZero(seed, one), d, is_seed);
    for (int i = 0; i < lanes; ++i) {
      if (is_seed[i] == 0) continue;
      const int kind = sums[i] > 0 ? kPositiveSeed : kNegativeSeed;
      seeds[u + i] = static_cast<uint8_t>(kind + 2 * pair[u + i]);
      ++count;
    }
  }
  return count;
}

HWY_NOINLINE int seedRow(const float* const residuals[kResidualSide], const uint8_t* pair,
                         int width, const SeedLimits& limits, uint8_t* seeds) {
  std::fill_n(seeds, width, uint8_t{kNoSeed});
  const int end = width - kResidualReach;
  int u = kResidualReach;
  const int count = seedsOf(hn::ScalableTag<float>(), residuals, pair, end, limits, u, seeds);
  return count + seedsOf(hn::FixedTag<float, 1>(), residuals, pair, end, limits, u, seeds);
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(seedRow);

int seedRow(const float* const residuals[kResidualSide], const uint8_t* pair, int width,
            const SeedLimits& limits, uint8_t* seeds) {
  return HWY_DYNAMIC_DISPATCH(seedRow)(residuals, pair, width, limits, seeds);
}

}  // namespace predictive_stereo
#endif
