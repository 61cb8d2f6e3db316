#include "detection/shift_rows.h"

#include <algorithm>
#include <cstring>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/shift_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

// Copies whole vectors: memcpy may write in two halves, which stalls the vector load that follows.
HWY_INLINE void copyPairs(const uint8_t* HWY_RESTRICT bytes, uint16_t (&pairs)[kShiftBlock]) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<uint8_t, sizeof pairs> d;
  auto* copy = reinterpret_cast<uint8_t*>(pairs);
  for (size_t i = 0; i < sizeof pairs; i += hn::Lanes(d))
    hn::StoreU(hn::LoadU(d, bytes + i), d, copy + i);
}

// Short loops without branches, which compilers vectorise.
HWY_NOINLINE void totalsOfShifts(const uint8_t* HWY_RESTRICT grey, const uint8_t* const* before,
                                 int samples, int trials, int32_t* HWY_RESTRICT total) {
  int16_t differences[kMostShiftedSamples][kShiftBlock];
  const auto count = static_cast<int16_t>(samples);
  for (int k = 0; k < trials; k += kShiftBlock) {
    int16_t sum[kShiftBlock] = {};
    for (int i = 0; i < samples; ++i) {
      const auto now = static_cast<int16_t>(grey[i]);
      uint16_t pairs[kShiftBlock];  // of columns; the first one is in the lower byte
      copyPairs(before[i] + 2 * k, pairs);
      for (int j = 0; j < kShiftBlock; ++j) {
        differences[i][j] = static_cast<int16_t>(now - static_cast<int16_t>(pairs[j] & 0xFF));
        sum[j] = static_cast<int16_t>(sum[j] + differences[i][j]);
      }
    }
    int32_t totals[kShiftBlock] = {};
    for (int i = 0; i < samples; ++i)
      for (int j = 0; j < kShiftBlock; ++j) {
        const auto scaled = static_cast<int16_t>(count * differences[i][j]);
        const auto rest = static_cast<int16_t>(std::max(scaled, sum[j]) - std::min(scaled, sum[j]));
        totals[j] += rest;
      }
    std::memcpy(total + k, totals, sizeof totals);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(totalsOfShifts);

void totalsOfShifts(const uint8_t* grey, const uint8_t* const* before, int samples, int trials,
                    int32_t* total) {
  HWY_DYNAMIC_DISPATCH(totalsOfShifts)(grey, before, samples, trials, total);
}

}  // namespace predictive_stereo
#endif
