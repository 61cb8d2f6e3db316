/// Cars that are difficult for stereo: dark, glossy and metallic paint, transparent windows.
#pragma once

#include "evaluation/simulation/models.h"

namespace predictive_stereo::simulation {

/// Gives all cars, vans and trucks glossy paint, mostly dark, and seats behind transparent windows.
void makeGlossy(Primitives& primitives);

}  // namespace predictive_stereo::simulation
