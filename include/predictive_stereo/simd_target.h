/// Which instructions the kernels use. One choice holds for all of a process: matching, filters,
/// ego-motion and detection.
#pragma once

#include <string>
#include <vector>

namespace predictive_stereo {

/// The targets that this build holds and this CPU can run, in the order in which "auto" prefers
/// them: of "avx2", "avx3" (AVX-512, which was measured to be slower), "sse4", "neon",
/// "neon_without_aes"; the last one is always "scalar": the plain references, and loops compiled
/// for what every CPU of this kind has. Results do not depend on the choice.
std::vector<std::string> availableSimdTargets();

/// Resolves a request: "auto" is the environment variable PREDICTIVE_STEREO_SIMD where that is set,
/// and the first of availableSimdTargets otherwise.
/// @throws std::invalid_argument for a name that is unknown or that this CPU cannot run.
std::string chooseSimdTarget(const std::string& requested);

/// What to tell the user where `target` is "scalar": that everything is slow, and the cure. Empty
/// for all others.
/// @param requested, target  what chooseSimdTarget was given and what it returned.
std::string slowTargetWarning(const std::string& requested, const std::string& target);

/// Lets all kernels of this process use what chooseSimdTarget says, from their next call on. A
/// Pipeline with disparities does so for its matcher/simd_target; before, it is "auto".
/// @throws std::invalid_argument as chooseSimdTarget does; nothing has changed then.
void useSimdTarget(const std::string& requested);
/// The name of the target in use.
std::string simdTargetInUse();

}  // namespace predictive_stereo
