/// Static indoor worlds, with little texture.
#pragma once

#include "evaluation/simulation/models.h"

namespace predictive_stereo::simulation {

/// A hall, x from -8 to 16 and y from -8 to 8, 7 m high: a floor without texture with a
/// chessboard, and shelves and machines along the walls.
void addHall(uint32_t seed, Primitives& out);

/// Two corridors with white walls that cross: along x at |y| < 1.25, from -6 to 44, and along y at
/// 13.5 < x < 16, from -22 to 22; 2.7 m high.
void addCorridor(uint32_t seed, Primitives& out);

}  // namespace predictive_stereo::simulation
