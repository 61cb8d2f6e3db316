#include "detection/dense_rows.h"

#include <algorithm>
#include <cmath>

#include "matching/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/dense_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

// Points at a time, so that the columns of their squares are whole vectors.
constexpr int kColumns = 64;
constexpr int kChunk = kColumns - 2 * kDenseReach;

// Known points count 1, and 256 more for a positive and less for a negative residual: one sum for
// both. A square has no more than 49.
constexpr int kSignUnit = 256;

HWY_INLINE float usable(float residual, float unknown) {
  return residual != unknown ? residual : 0.0f;
}

HWY_INLINE int32_t tallyOf(float residual, float unknown) {
  const float value = usable(residual, unknown);
  return (residual != unknown ? 1 : 0) + (value > 0 ? kSignUnit : 0) - (value < 0 ? kSignUnit : 0);
}

// Sums over squares of kDenseSide columns.
template <class T>
HWY_INLINE T alongRow(const T* columns) {
  static_assert(kDenseSide == 7, "written out");
  return columns[0] + columns[1] + columns[2] + columns[3] + columns[4] + columns[5] + columns[6];
}

HWY_NOINLINE int seedRow(const float* const residuals[kDenseSide], int width,
                         const SeedLimits& limits, uint8_t* HWY_RESTRICT seeds) {
  static_assert(kDenseSide == 7, "sums are written out");
  // Sums of a square's columns, around the points of a chunk; 0 outside of the map.
  float value[kColumns + 2 * kDenseReach] = {}, sum[kColumns];
  int32_t tally[kColumns + 2 * kDenseReach] = {};
  const float unknown = limits.unknown, least_mean = limits.least_mean,
              least_sign = limits.least_sign;
  const int32_t fewest = limits.fewest_known;
  const float least_sum = least_mean * static_cast<float>(fewest);
  int32_t count = 0;
  for (int u = 0; u < width; u += kChunk) {
    const int n = std::min(kChunk, width - u);
    const int first = std::max(u - kDenseReach, 0), end = std::min(u + n + kDenseReach, width);
    const int before = first - (u - kDenseReach), m = end - first;
    std::fill_n(value, before, 0.0f);
    std::fill(value + before + m, value + kColumns, 0.0f);
    const float *r0 = residuals[0] + first, *r1 = residuals[1] + first, *r2 = residuals[2] + first,
                *r3 = residuals[3] + first, *r4 = residuals[4] + first, *r5 = residuals[5] + first,
                *r6 = residuals[6] + first;
    for (int i = 0; i < m; ++i)
      value[before + i] = usable(r0[i], unknown) + usable(r1[i], unknown) + usable(r2[i], unknown) +
                          usable(r3[i], unknown) + usable(r4[i], unknown) + usable(r5[i], unknown) +
                          usable(r6[i], unknown);
    // Most chunks end here.
    int32_t any = 0;
    for (int i = 0; i < kColumns; ++i) sum[i] = alongRow(value + i);
    for (int i = 0; i < kColumns; ++i) any |= std::abs(sum[i]) >= least_sum ? 1 : 0;
    if (any == 0) {
      std::fill_n(seeds + u, n, uint8_t{kNoSeed});
      continue;
    }
    std::fill_n(tally, before, 0);
    std::fill(tally + before + m, tally + n + 2 * kDenseReach, 0);
    for (int i = 0; i < m; ++i)
      tally[before + i] = tallyOf(r0[i], unknown) + tallyOf(r1[i], unknown) +
                          tallyOf(r2[i], unknown) + tallyOf(r3[i], unknown) +
                          tallyOf(r4[i], unknown) + tallyOf(r5[i], unknown) +
                          tallyOf(r6[i], unknown);
    const float* HWY_RESTRICT centre = residuals[kDenseReach] + u;
    for (int i = 0; i < n; ++i) {
      const int32_t both = alongRow(tally + i);
      const int32_t known = both & (kSignUnit - 1);
      const auto weight = static_cast<float>(known);
      const auto sign = static_cast<float>((both - known) / kSignUnit);
      const bool seed = (known >= fewest) & (std::abs(sum[i]) >= least_mean * weight) &
                        (std::abs(sign) >= least_sign * weight) & (centre[i] != unknown);
      const int32_t kind = sum[i] > 0 ? kPositiveSeed : kNegativeSeed;
      seeds[u + i] = static_cast<uint8_t>(seed ? kind : kNoSeed);
      count += seed ? 1 : 0;
    }
  }
  return count;
}

namespace hn = hwy::HWY_NAMESPACE;

// Points from u on, as long as vectors fit; `u` is then the first that did not.
template <class D>
HWY_INLINE int slowSeeds(D d, const float* const residuals[kSlowSide],
                         const uint8_t* HWY_RESTRICT pair, int end, const SeedLimits& limits,
                         int& u, uint8_t* HWY_RESTRICT seeds) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto unknown = hn::Set(d, limits.unknown), least = hn::Set(d, limits.least_mean),
             zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  HWY_ALIGN float sums[hn::MaxLanes(D())], is_seed[hn::MaxLanes(D())];
  int count = 0;
  for (; u + lanes <= end; u += lanes) {
    const auto centre = hn::LoadU(d, residuals[kSlowReach] + u);
    const auto large = hn::Ge(hn::Abs(centre), hn::Mul(hn::Set(d, 0.5f), least));
    const auto promising = hn::And(large, hn::Ne(centre, unknown));
    if (hn::AllFalse(d, promising)) continue;
    auto sum = zero, known = zero, sign = zero;
    for (int j = 0; j < kSlowSide; ++j)
      for (int i = -kSlowReach; i <= kSlowReach; ++i) {
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

HWY_NOINLINE int slowSeedRow(const float* const residuals[kSlowSide], const uint8_t* pair,
                             int width, const SeedLimits& limits, uint8_t* seeds) {
  std::fill_n(seeds, width, uint8_t{kNoSeed});
  const int end = width - kSlowReach;
  int u = kSlowReach;
  const int count = slowSeeds(hn::ScalableTag<float>(), residuals, pair, end, limits, u, seeds);
  return count + slowSeeds(hn::FixedTag<float, 1>(), residuals, pair, end, limits, u, seeds);
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(seedRow);
HWY_EXPORT(slowSeedRow);

int seedRow(const float* const residuals[kDenseSide], int width, const SeedLimits& limits,
            uint8_t* seeds) {
  return HWY_DYNAMIC_DISPATCH(seedRow)(residuals, width, limits, seeds);
}

int slowSeedRow(const float* const residuals[kSlowSide], const uint8_t* pair, int width,
                const SeedLimits& limits, uint8_t* seeds) {
  return HWY_DYNAMIC_DISPATCH(slowSeedRow)(residuals, pair, width, limits, seeds);
}

}  // namespace predictive_stereo
#endif
