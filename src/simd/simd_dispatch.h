/// Run-time dispatch to the kernels of one SIMD target. Include before Highway.
///
/// HWY_DYNAMIC_DISPATCH calls the kernel of the process's target (useSimdTarget),
/// PREDICTIVE_STEREO_DISPATCH that of a given target.
#pragma once

// Targets that gain little over others, most of them only in later releases of Highway, and targets
// without a vector size that is known at compile time, which the kernels need.
#define HWY_DISABLED_TARGETS                                                         \
  (HWY_SSE2 | HWY_SSSE3 | HWY_AVX3_DL | HWY_AVX3_ZEN4 | HWY_AVX3_SPR | HWY_AVX10_2 | \
   HWY_NEON_BF16 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#include <hwy/detect_targets.h>
// Not defined by every release from 1.0 on.
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

/// Whether the target being compiled has vectors. If not, its kernels are empty and never called:
/// the plain reference takes their place.
#define PREDICTIVE_STEREO_HAS_VECTORS (HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128)

/// Around the kernels of a file: the namespace of the SIMD target that is being compiled, in which
/// Highway is `hn`.
#define PREDICTIVE_STEREO_BEGIN_KERNELS \
  HWY_BEFORE_NAMESPACE();               \
  namespace predictive_stereo {         \
  namespace HWY_NAMESPACE {             \
  namespace hn = hwy::HWY_NAMESPACE;    \
  static_assert(true, "for a semicolon")
#define PREDICTIVE_STEREO_END_KERNELS \
  }                                   \
  }                                   \
  HWY_AFTER_NAMESPACE()

#include <hwy/targets.h>

#include <cstdint>
#include <string>

namespace predictive_stereo {

constexpr int64_t kScalarTarget = 0;

/// Highway's bit of a target named by chooseSimdTarget; kScalarTarget for "scalar".
int64_t simdTargetBit(const std::string& name);

/// Bits of the targets that can run if Highway detects `detected` (hwy::SupportedTargets).
int64_t runnableSimdTargets(int64_t detected);

/// Highway's bit of the target that useSimdTarget has set.
int64_t simdTargetBitInUse();

/// Index of a target in the tables of HWY_EXPORT.
inline size_t simdTableIndex(int64_t target_bit, size_t table_size) {
  if (table_size == 1) return 0;
  hwy::ChosenTarget chosen;
  chosen.Update(target_bit);
  return chosen.GetIndex();
}

}  // namespace predictive_stereo

/// The function `NAME` of HWY_EXPORT for the target with this bit.
#define PREDICTIVE_STEREO_DISPATCH(NAME, TARGET_BIT)              \
  (*HWY_DISPATCH_TABLE(NAME)[::predictive_stereo::simdTableIndex( \
      TARGET_BIT, sizeof(HWY_DISPATCH_TABLE(NAME)) / sizeof(void*))])
