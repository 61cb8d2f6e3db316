#include "predictive_stereo/simd_target.h"

#include <atomic>
#include <cstdlib>
#include <stdexcept>

#include "matching/simd_dispatch.h"

namespace predictive_stereo {
namespace {

struct NamedTarget {
  const char* name;
  int64_t bit;
};

/// Best first.
constexpr NamedTarget kTargets[] = {
#if HWY_ARCH_X86
    {"avx3", HWY_AVX3},
    {"avx2", HWY_AVX2},
    {"sse4", HWY_SSE4},
#elif HWY_ARCH_ARM
    {"neon", HWY_NEON},
#endif
    {"scalar", kScalarTarget},
};

bool canRun(int64_t bit) {
  // Asked once: to ask also makes Highway dispatch to the best target from then on.
  static const int64_t supported = hwy::SupportedTargets();
  return bit == kScalarTarget || (supported & HWY_TARGETS & bit) != 0;
}

std::atomic<int64_t> bit_in_use{kScalarTarget};

void use(int64_t bit) {
  bit_in_use = bit;
  hwy::GetChosenTarget().Update(bit);  // HWY_DYNAMIC_DISPATCH asks this one
}

// When the library is loaded. A name that cannot be used is told to those who choose.
[[maybe_unused]] const bool is_chosen = [] {
  try {
    useSimdTarget("auto");
  } catch (const std::invalid_argument&) {
    use(simdTargetBit(availableSimdTargets().front()));
  }
  return true;
}();

}  // namespace

int64_t simdTargetBitInUse() { return bit_in_use; }

int64_t simdTargetBit(const std::string& name) {
  for (const NamedTarget& target : kTargets)
    if (name == target.name && canRun(target.bit)) return target.bit;
  return kScalarTarget;
}

std::vector<std::string> availableSimdTargets() {
  std::vector<std::string> names;
  for (const NamedTarget& target : kTargets)
    if (canRun(target.bit)) names.emplace_back(target.name);
  return names;
}

std::string chooseSimdTarget(const std::string& requested) {
  std::string name = requested, origin = "simd_target";
  const char* environment = std::getenv("PREDICTIVE_STEREO_SIMD");
  if (name == "auto" && environment && *environment) {
    name = environment;
    origin = "environment variable PREDICTIVE_STEREO_SIMD";
  }
  const std::vector<std::string> available = availableSimdTargets();
  if (name == "auto") return available.front();
  std::string choices = "auto";
  for (const std::string& candidate : available) {
    if (name == candidate) return name;
    choices += ", " + candidate;
  }
  throw std::invalid_argument(origin + " = " + name + ": this build and CPU can run " + choices);
}

void useSimdTarget(const std::string& requested) {
  use(simdTargetBit(chooseSimdTarget(requested)));
}

std::string simdTargetInUse() {
  for (const NamedTarget& target : kTargets)
    if (target.bit == bit_in_use) return target.name;
  return "scalar";
}

}  // namespace predictive_stereo
