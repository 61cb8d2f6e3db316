#include "predictive_stereo/simd_target.h"

#include <atomic>
#include <cstdlib>
#include <stdexcept>

#include "simd/simd_dispatch.h"

namespace predictive_stereo {
namespace {

struct NamedTarget {
  const char* name;
  int64_t bit;
};

/// In the order in which "auto" prefers them. AVX-512 comes after AVX2: its wider vectors made the
/// kernels slower on the CPUs that were measured (docs/design_notes.md).
constexpr NamedTarget kTargets[] = {
#if HWY_ARCH_X86
    {"avx2", HWY_AVX2},
    {"avx3", HWY_AVX3},
    {"sse4", HWY_SSE4},
#elif HWY_ARCH_ARM
    {"neon", HWY_NEON},
#ifdef HWY_NEON_WITHOUT_AES  // Highway 1.0 has only HWY_NEON
    {"neon_without_aes", HWY_NEON_WITHOUT_AES},
#endif
#endif
    {"scalar", kScalarTarget},
};

bool canRun(int64_t bit) {
  // Called only once: SupportedTargets() also makes Highway dispatch to the best target.
  static const int64_t runnable = runnableSimdTargets(hwy::SupportedTargets());
  return bit == kScalarTarget || (runnable & bit) != 0;
}

#if HWY_ARCH_X86
constexpr char kCure[] =
    "the CPU has neither AVX2 nor SSE4.2 with AES. In a virtual machine, expose the host's CPU "
    "(QEMU: -cpu host); otherwise use another CPU";
#elif HWY_ARCH_ARM
constexpr char kCure[] =
    "this build or CPU has no NEON. Use a 64-bit system; on 32 bits, compile with "
    "-DCMAKE_CXX_FLAGS=-mfpu=neon-vfpv4";
#else
constexpr char kCure[] = "the kernels are written for x86 and Arm CPUs. Use one of these";
#endif

// The target that PREDICTIVE_STEREO_SIMD names; empty if it is not set or "auto".
std::string targetOfEnvironment() {
  const char* variable = std::getenv("PREDICTIVE_STEREO_SIMD");
  const std::string name = variable ? variable : "";
  return name == "auto" ? "" : name;
}

std::atomic<int64_t> bit_in_use{kScalarTarget};

void setTarget(int64_t bit) {
  bit_in_use = bit;
  hwy::GetChosenTarget().Update(bit);  // for HWY_DYNAMIC_DISPATCH
}

// Runs when the library is loaded. A wrong name in the environment is reported later, by
// chooseSimdTarget.
[[maybe_unused]] const bool is_chosen = [] {
  try {
    useSimdTarget("auto");
  } catch (const std::invalid_argument&) {
    setTarget(simdTargetBit(availableSimdTargets().front()));
  }
  return true;
}();

}  // namespace

int64_t runnableSimdTargets(int64_t detected) {
  // The compiler may use HWY_STATIC_TARGET everywhere, so it can always run. Highway 1.0 does not
  // report it on some CPUs: it reports NEON only with AES, which a Raspberry Pi 4 does not have. No
  // kernel uses AES.
  return (detected | HWY_STATIC_TARGET) & HWY_TARGETS;
}

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
  const std::string environment = targetOfEnvironment();
  if (name == "auto" && !environment.empty()) {
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
  throw std::invalid_argument(origin + " = " + name + ": on this build and CPU it must be one of " +
                              choices);
}

void useSimdTarget(const std::string& requested) {
  setTarget(simdTargetBit(chooseSimdTarget(requested)));
}

std::string slowTargetWarning(const std::string& requested, const std::string& target) {
  if (target != "scalar") return "";
  const std::string slow =
      "simd_target is scalar: no SIMD instructions are used, and a frame takes about 20 times as "
      "long. ";
  if (requested != "auto") return slow + "Cure: set simd_target to auto";
  if (!targetOfEnvironment().empty())
    return slow + "Cure: unset the environment variable PREDICTIVE_STEREO_SIMD";
  return slow + "Cause and cure: " + kCure;
}

}  // namespace predictive_stereo
