/// Run-time dispatch to the kernels of one SIMD target. Include before Highway.
///
/// Kernels are dispatched by HWY_DYNAMIC_DISPATCH to the target of the process (useSimdTarget), or
/// by PREDICTIVE_STEREO_DISPATCH to one that the caller names.
#pragma once

// SSSE3 and AVX3_DL gain little over their neighbours; the kernels want vectors of a known size.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)

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
