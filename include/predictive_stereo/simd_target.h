/// Which instructions the matching kernels use.
#pragma once

#include <string>
#include <vector>

namespace predictive_stereo {

/// The targets that this build holds and this CPU can run, best first: of "avx3" (AVX-512),
/// "avx2", "sse4", "neon"; the last one is always "scalar", the plain reference. Results do
/// not depend on the choice.
std::vector<std::string> availableSimdTargets();

/// Resolves a request: "auto" is the environment variable PREDICTIVE_STEREO_SIMD where that is set,
/// and the best target otherwise.
/// @throws std::invalid_argument for a name that is unknown or that this CPU cannot run.
std::string chooseSimdTarget(const std::string& requested);

}  // namespace predictive_stereo
