/// The SIMD target: the instruction set that the kernels use. One choice holds for the whole
/// process: matching, filters, ego-motion and detection.
#pragma once

#include <string>
#include <vector>

namespace predictive_stereo {

/// The targets that this build contains and this CPU can run, in the order in which "auto" prefers
/// them. Possible ones are "avx2", "avx3" (AVX-512, slower than AVX2 where it was measured),
/// "sse4", "neon" and "neon_without_aes". The last one is always "scalar": plain C++ for any CPU of
/// this architecture. Results do not depend on the target.
std::vector<std::string> availableSimdTargets();

/// The target that a request selects. "auto" selects that of the environment variable
/// PREDICTIVE_STEREO_SIMD if it is set, otherwise the first of availableSimdTargets().
/// @throws std::invalid_argument for a name that is unknown or that this CPU cannot run.
std::string chooseSimdTarget(const std::string& requested);

/// A warning for the user if `target` is "scalar", which is slow: cause and cure. Empty for all
/// other targets.
/// @param requested, target  argument and result of chooseSimdTarget.
std::string slowTargetWarning(const std::string& requested, const std::string& target);

/// Sets the target of all kernels of this process to chooseSimdTarget(requested), from their next
/// call on. DisparityLoop calls this with its matcher/simd_target; until
/// then the target is "auto".
/// @throws std::invalid_argument as chooseSimdTarget does; the target is then unchanged.
void useSimdTarget(const std::string& requested);

}  // namespace predictive_stereo
