/// Tests of kernels on all SIMD targets of this machine.
#pragma once

#include <gtest/gtest.h>

#include "simd/simd_dispatch.h"

namespace predictive_stereo {

/// Calls body() on every target of the kernels that Highway dispatches.
template <class Body>
void forEveryTarget(const Body& body) {
  for (auto targets = hwy::SupportedTargets(); targets; targets &= targets - 1) {
    const auto target = targets & ~(targets - 1);
    hwy::SetSupportedTargetsForTest(target);
    SCOPED_TRACE(hwy::TargetName(target));
    body();
  }
  hwy::SetSupportedTargetsForTest(0);
}

}  // namespace predictive_stereo
