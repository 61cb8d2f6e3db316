/// Run-time dispatch to the kernels of one SIMD target. Include before Highway.
///
/// Kernels are dispatched by HWY_DYNAMIC_DISPATCH to the target of the process (useSimdTarget), or
/// by PREDICTIVE_STEREO_DISPATCH to one that the caller names.
#pragma once

// Those that gain little over their neighbours: later releases of Highway have more of them. The
// kernels want vectors of a known size.
#define HWY_DISABLED_TARGETS                                                         \
  (HWY_SSE2 | HWY_SSSE3 | HWY_AVX3_DL | HWY_AVX3_ZEN4 | HWY_AVX3_SPR | HWY_AVX10_2 | \
   HWY_NEON_BF16 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#include <hwy/detect_targets.h>
// Not known to every release from 1.0 on.
#ifndef HWY_SSE2
#define HWY_SSE2 0
#endif
#ifndef HWY_AVX3_ZEN4
#define HWY_AVX3_ZEN4 0
#endif
#ifndef HWY_AVX3_SPR
#define HWY_AVX3_SPR 0
#endif
#ifndef HWY_AVX10_2
#define HWY_AVX10_2 0
#endif
#ifndef HWY_NEON_BF16
#define HWY_NEON_BF16 0
#endif

/// Whether the target being compiled has vectors. Kernels are empty where it has not, and never
/// called: the plain reference takes their place.
#define PREDICTIVE_STEREO_HAS_VECTORS (HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128)

#include <hwy/targets.h>

#include <cstdint>
#include <string>

namespace predictive_stereo {

constexpr int64_t kScalarTarget = 0;

/// Highway's bit of a target named by chooseSimdTarget; kScalarTarget for "scalar".
int64_t simdTargetBit(const std::string& name);

/// Bits of the targets that can run where Highway detects `detected` (hwy::SupportedTargets).
int64_t runnableSimdTargets(int64_t detected);

/// That of useSimdTarget.
int64_t simdTargetBitInUse();

/// Place of a target in the tables of HWY_EXPORT.
inline size_t simdTableIndex(int64_t target_bit, size_t table_size) {
  if (table_size == 1) return 0;
  hwy::ChosenTarget chosen;
  chosen.Update(target_bit);
  return chosen.GetIndex();
}

}  // namespace predictive_stereo

/// The function `NAME`, exported by HWY_EXPORT, of the target with this bit.
#define PREDICTIVE_STEREO_DISPATCH(NAME, TARGET_BIT)              \
  (*HWY_DISPATCH_TABLE(NAME)[::predictive_stereo::simdTableIndex( \
      TARGET_BIT, sizeof(HWY_DISPATCH_TABLE(NAME)) / sizeof(void*))])
